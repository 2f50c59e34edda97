// test: unoptimised test asan tsan
#include "../standard.hpp"
#include <iomanip>
#include <tilemesh/report/table.hpp>

using tilemesh::report::Table;
using tilemesh::report::thousands;

TEST_SUITE_BEGIN("report");

TEST_CASE("thousands are set off by commas")
{
    CHECK(thousands(0) == "0");
    CHECK(thousands(999) == "999");
    CHECK(thousands(1000) == "1,000");
    CHECK(thousands(1440) == "1,440");
    CHECK(thousands(25161) == "25,161");
    CHECK(thousands(999999) == "999,999");
    CHECK(thousands(1000000) == "1,000,000");
    CHECK(thousands(std::numeric_limits<std::uint64_t>::max()) == "18,446,744,073,709,551,615");
}

TEST_CASE("columns are right-aligned and as wide as their widest cell")
{
    Table table{{"stage", "ms"}};
    table.add_row({"route", "12.5"}).add_row({"composite", "3"});
    std::ostringstream out;
    out << std::setw(40) << std::left << table << "end";
    CHECK(out.str() == "    stage    ms\n"
                       "---------  ----\n"
                       "    route  12.5\n"
                       "composite     3\n"
                       "end");
}

TEST_CASE("width is counted in code points")
{
    Table table{{"a", "b"}};
    table.add_row({"\xc3\xa9t\xc3\xa9", "1"}); // été
    std::ostringstream out;
    out << table;
    CHECK(out.str() == "  a  b\n---  -\n\xc3\xa9t\xc3\xa9  1\n");
}

TEST_CASE("a table without rows or columns")
{
    std::ostringstream out;
    out << Table{{"only"}} << Table{{}};
    CHECK(out.str() == "only\n----\n\n\n");
}

TEST_CASE("a row of another length is refused")
{
    Table table{{"a", "b"}};
    CHECK_THROWS_AS(table.add_row({"1"}), tilemesh::Error);
    CHECK_THROWS_AS(table.add_row({"1", "2", "3"}), tilemesh::Error);
    std::ostringstream out;
    out << table;
    CHECK(out.str() == "a  b\n-  -\n");
}

TEST_SUITE_END();
