// Usage: report_schema SCHEMA REPORT... | report_schema --write SCHEMA
// --write brings the schema up to date with `report_fields`.
// Each report is valid; all of them together have every member that the schema names; and no report stays valid if a member is left out
// that each report has, if a member is added, or if a value gets another type.
#include "../report/json_schema.hpp"
#include <cstddef>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

int main(int argc, char** argv)
{
    using json_schema::Json;
    if (argc < 3) return 2;
    auto const parsed = [](char const* path) {
        std::ifstream in(path);
        return Json::parse(in);
    };
    if (argv[1] == std::string("--write")) {
        auto const text = json_schema::text_of(json_schema::with_fields(parsed(argv[2]))) + "\n";
        return std::ofstream(argv[2]) << text ? 0 : 1;
    }
    int failures = 0;
    auto const fail = [&](std::string const& text) {
        std::cerr << "FAILED: " << text << "\n";
        ++failures;
    };
    try {
        auto const schema = parsed(argv[1]);
        json_schema::Validator validator(schema);
        std::vector<Json> reports;
        for (int i = 2; i < argc; ++i) {
            reports.push_back(parsed(argv[i]));
            auto errors = validator.errors(reports.back());
            if (errors.size() > 10) errors.resize(10);
            for (auto const& error : errors) fail(std::string(argv[i]) + ": " + error);
        }
        for (auto const& member : validator.unseen())
            if (member != "#/ranks") fail("no report has " + member); // runs over the ranks of MPI have a check of their own

        std::size_t noticed = 0, allowed = 0;
        for (auto& report : reports) {
            for (auto& frame : report["frames"]) { // a list of thousands would be copied for each change
                auto few = Json::array();
                for (auto const& loss : frame["lost"])
                    if (few.size() < 3) few.push_back(loss);
                frame["lost"] = few;
            }
            for (auto const& [how, spoiled] : json_schema::spoiled(report)) {
                bool const valid = validator.errors(spoiled).empty();
                ++(valid ? allowed : noticed);
                if (valid && !how.starts_with("without ")) fail("not noticed: " + how);
            }
        }
        std::cout << "report_schema: " << reports.size() << " reports; " << noticed << " changes noticed, " << allowed
                  << " optional members\n";
        if (noticed < 20 * allowed) fail("nearly every member is optional");
    } catch (std::exception const& error) {
        fail(error.what());
    }
    return failures == 0 ? 0 : 1;
}
