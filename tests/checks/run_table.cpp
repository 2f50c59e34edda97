// Runs a table of checks of programs, in an empty folder of its own, and names every row that fails.
// usage: run_table TABLE [NAME=VALUE...]: the values are variables of the table; PROGRAM names the program of its rows.
//
// A line is a statement, or several with ` :: ` between them; lines that are indented deeper belong to it; ` \` at the end of a line joins the
// next one.
//   NAME = VALUE             a variable: $NAME in later lines, and in the environment of every command; $(COMMAND) is what it prints
//   each NAMES = V | V | V   the block once for each value (without "|", a value is a word); several names share a value's words, and the last one takes the rest
//   when COMMAND => WHY      the block if the command ends with 0; otherwise "skipped: WHY" (without WHY: nothing)
//   sh COMMANDS              shell commands with the functions of common.sh; they must end with 0; a block goes on with them
//   run ARGUMENTS            $PROGRAM with shell words: status 0, no standard error but one line of what the pictures lack
//   ends STATUS ARGUMENTS    $PROGRAM ends with this status
//   refuse ARGUMENTS => PATTERN  status 2, nothing on standard output, one line "<problem> (<why>); <what to do>" that matches, and no file changes
//   stop ARGUMENTS => PATTERN    the same line and status of a run that has begun: it may have printed and written files
//   has FILE PATTERN, hasnt FILE PATTERN   a basic regular expression, by lines
//   same A B, differ A B, here FILE..., gone FILE...
//   is A = B, is A < B, ... [within T]     expressions of words: numbers, "texts", + - * / ( ), FILE.json:path.*.to.value (** is any path),
//                            FILE.csv:column[@row or @column=value], and sum() min() max() count() of these; lines(FILE) bytes(FILE) files(GLOB)
//   fails STATEMENT          the statement must fail
// After each run, no file.part is left, and every PNG and JSON file that it wrote is whole.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <glob.h>
#include <iostream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex.h>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Texts = std::vector<std::string>;
using Error = std::runtime_error;

std::string contents(fs::path const& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in || fs::is_directory(path)) throw Error("there is no file " + path.string());
    return {std::istreambuf_iterator<char>(in), {}};
}
std::string trimmed(std::string const& text)
{
    auto const first = text.find_first_not_of(" \n\t");
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \n\t") + 1 - first);
}
/// The text before a separator and the text after it, both trimmed; everything and nothing if it is not there.
std::pair<std::string, std::string> split(std::string const& text, std::string const& separator)
{
    auto const at = text.find(separator);
    if (at == std::string::npos) return {trimmed(text), ""};
    return {trimmed(text.substr(0, at)), trimmed(text.substr(at + separator.size()))};
}
Texts pieces(std::string const& text, char separator)
{
    Texts all(1);
    for (char const c : text)
        if (c == separator) all.emplace_back();
        else all.back() += c;
    return all;
}
Texts words(std::string const& text)
{
    std::istringstream in(text);
    return {std::istream_iterator<std::string>(in), {}};
}
std::string joined(Texts const& texts)
{
    std::string all;
    for (auto const& text : texts) all += (all.empty() ? "" : " ") + text;
    return all;
}
std::string beginning(std::string const& text) { return text.size() <= 600 ? trimmed(text) : text.substr(0, 600) + "..."; }
std::optional<double> number_of(std::string const& text)
{
    char* end = nullptr;
    auto const value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0') return {};
    return value;
}
bool matches(std::string const& text, std::string const& pattern)
{
    regex_t expression;
    if (regcomp(&expression, pattern.c_str(), REG_NEWLINE) != 0) throw Error("no regular expression: " + pattern);
    regmatch_t range{0, static_cast<regoff_t>(text.size())};
    bool const found = regexec(&expression, text.c_str(), 1, &range, REG_STARTEND) == 0;
    regfree(&expression);
    return found;
}

// --- values of files ---------------------------------------------------------------------------

/// The values of a JSON text in order, each with the path to it. Strings are without quotes.
using Values = std::vector<std::pair<std::string, std::string>>;
void add_values(nlohmann::ordered_json const& json, std::string const& path, Values& to)
{
    if (json.is_string()) to.emplace_back(path, json.get<std::string>());
    else if (!json.is_structured()) to.emplace_back(path, json.dump());
    else for (auto const& [name, value] : json.items()) add_values(value, path.empty() ? name : path + "." + name, to);
}
Values json_values(std::string const& text)
{
    auto const json = nlohmann::ordered_json::parse(text, nullptr, false);
    if (json.is_discarded()) throw Error("no JSON");
    Values values;
    add_values(json, "", values);
    return values;
}

/// Whether a path is as a pattern says, in which * is any name and ** any names.
bool is_path(Texts const& path, Texts const& pattern, std::size_t i = 0, std::size_t k = 0)
{
    if (k == pattern.size()) return i == path.size();
    if (pattern[k] == "**") return is_path(path, pattern, i, k + 1) || (i < path.size() && is_path(path, pattern, i + 1, k));
    return i < path.size() && (pattern[k] == "*" || pattern[k] == path[i]) && is_path(path, pattern, i + 1, k + 1);
}
std::vector<Texts> rows_of(std::string const& text)
{
    std::vector<Texts> rows;
    bool quoted = false, fresh = true;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (fresh) rows.emplace_back(1), fresh = false;
        if (text[i] == '"' && quoted && i + 1 < text.size() && text[i + 1] == '"') rows.back().back() += text[i++];
        else if (text[i] == '"') quoted = !quoted;
        else if (text[i] == ',' && !quoted) rows.back().emplace_back();
        else if (text[i] == '\n' && !quoted) fresh = true;
        else rows.back().back() += text[i];
    }
    return rows;
}
/// The values of FILE.json:path or FILE.csv:column@row; nothing if the word is another one.
std::optional<Texts> values_of(std::string const& word)
{
    auto const colon = word.find(':');
    if (colon == std::string::npos || colon == 0) return {};
    auto const file = word.substr(0, colon), what = word.substr(colon + 1);
    bool const csv = file.ends_with(".csv");
    if (!csv && !file.ends_with(".json")) return {};
    Texts found;
    if (!csv) {
        for (auto const& [path, value] : json_values(contents(file)))
            if (is_path(pieces(path, '.'), pieces(what, '.'))) found.push_back(value);
        return found;
    }
    auto const rows = rows_of(contents(file));
    auto const column = [&](std::string const& name) {
        auto const at = rows.empty() ? Texts::const_iterator{} : std::find(rows[0].begin(), rows[0].end(), name);
        if (rows.empty() || at == rows[0].end()) throw Error("no column " + name + " in " + file);
        return static_cast<std::size_t>(at - rows[0].begin());
    };
    auto const at_sign = what.find('@');
    auto const wanted = column(what.substr(0, at_sign));
    auto const row = at_sign == std::string::npos ? "" : what.substr(at_sign + 1);
    auto const equals = row.find('=');
    for (std::size_t r = 1; r < rows.size(); ++r) {
        if (equals != std::string::npos ? rows[r].at(column(row.substr(0, equals))) != row.substr(equals + 1) : !row.empty() && row != std::to_string(r)) continue;
        found.push_back(rows[r].at(wanted));
    }
    return found;
}

// --- expressions -------------------------------------------------------------------------------

std::string shown(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}
class Expression {
public:
    explicit Expression(std::string const& text)
    {
        for (std::size_t i = 0; i < text.size();) {
            if (std::isspace(static_cast<unsigned char>(text[i]))) { ++i; continue; }
            bool const quoted = text[i] == '"';
            auto end = text.find(quoted ? '"' : ' ', i + 1);
            end = std::min(end, text.size());
            words_.push_back(text.substr(i, end - i) + (quoted ? "\"" : ""));
            i = end + (quoted ? 1 : 0);
        }
    }
    /// Nothing, or what is wrong.
    std::string check()
    {
        auto const left = sum();
        auto const how = next();
        auto const right = sum();
        double tolerance = 0;
        if (at_ < words_.size()) {
            if (next() != "within") throw Error("no expression");
            tolerance = as_number(sum());
        }
        if (at_ != words_.size()) throw Error("no expression after " + words_[at_]);
        auto const a = number_of(left), b = number_of(right);
        bool holds = false;
        if (how == "=" || how == "!=") holds = (a && b ? std::abs(*a - *b) <= tolerance || *a == *b : left == right) == (how == "=");
        else if (a && b) holds = how == "<" ? *a < *b : how == "<=" ? *a <= *b : how == ">" ? *a > *b : how == ">=" && *a >= *b;
        return holds ? "" : beginning(left) + " " + how + " " + beginning(right) + " is wrong";
    }

private:
    static double as_number(std::string const& text)
    {
        if (auto const value = number_of(text)) return *value;
        throw Error("\"" + beginning(text) + "\" is no number");
    }
    std::string next() { return at_ < words_.size() ? words_[at_++] : throw Error("an expression ends early"); }
    bool take(std::string const& word) { return at_ < words_.size() && words_[at_] == word && ++at_ > 0; }
    std::string sum()
    {
        auto value = product();
        for (;;)
            if (take("+")) value = shown(as_number(value) + as_number(product()));
            else if (take("-")) value = shown(as_number(value) - as_number(product()));
            else return value;
    }
    std::string product()
    {
        auto value = term();
        for (;;)
            if (take("*")) value = shown(as_number(value) * as_number(term()));
            else if (take("/")) value = shown(as_number(value) / as_number(term()));
            else return value;
    }
    std::string term()
    {
        auto word = next();
        if (word == "(") {
            auto value = sum();
            if (!take(")")) throw Error("no )");
            return value;
        }
        bool const quoted = word.front() == '"';
        if (quoted) word = word.substr(1, word.size() - 2);
        if (auto const open = word.find('('); !quoted && open != std::string::npos && word.back() == ')') {
            auto const name = word.substr(0, open), of = word.substr(open + 1, word.size() - open - 2);
            if (name == "bytes") return std::to_string(contents(of).size());
            if (name == "lines") return std::to_string(pieces(contents(of), '\n').size() - 1);
            if (name == "files") {
                glob_t found{};
                auto const n = glob(of.c_str(), 0, nullptr, &found) == 0 ? found.gl_pathc : 0;
                globfree(&found);
                return std::to_string(n);
            }
            auto const values = values_of(of);
            if (!values) throw Error(of + " names no values");
            if (name == "count") return std::to_string(values->size());
            double total = name == "min" ? INFINITY : name == "max" ? -INFINITY : 0;
            for (auto const& value : *values) {
                auto const v = as_number(value);
                total = name == "sum" ? total + v : name == "min" ? std::min(total, v) : name == "max" ? std::max(total, v) : throw Error("no function " + name);
            }
            return shown(total);
        }
        if (auto const values = values_of(word)) return joined(*values);
        return word;
    }
    Texts words_;
    std::size_t at_ = 0;
};

// --- the table ---------------------------------------------------------------------------------

struct Line {
    int number = 0;
    std::string text;
    std::string script; ///< the block of `sh`
    std::vector<Line> block;
};

/// Every file below the folder, by what changes with its content.
using Files = std::map<std::string, std::vector<long long>>;
Files files_now()
{
    Files files;
    for (auto const& entry : fs::recursive_directory_iterator(".", fs::directory_options::skip_permission_denied)) {
        struct stat s {};
        auto const name = entry.path().string();
        if (name == "./stdout" || name == "./stderr" || lstat(name.c_str(), &s) != 0) continue;
        auto& facts = files[name];
        facts = {static_cast<long long>(s.st_mode), static_cast<long long>(s.st_ino)};
        if (!S_ISDIR(s.st_mode)) facts.insert(facts.end(), {s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec});
    }
    return files;
}

class Table {
public:
    explicit Table(fs::path const& path) : name_(path.filename().string())
    {
        std::istringstream in(contents(path));
        std::string text;
        for (int number = 1; std::getline(in, text); ++number) lines_.push_back({number, text, {}, {}});
        std::size_t i = 0;
        rows_ = parsed(i, 0);
    }
    int run()
    {
        run(rows_);
        if (done_ == 0) std::cout << "FAILED: " << name_ << " has no check\n", ++failures_;
        std::cout << name_ << ": " << done_ << " checks, " << (failures_ == 0 ? "all good" : std::to_string(failures_) + " failures") << "\n";
        return failures_ == 0 ? 0 : 1;
    }
    void set(std::string const& name, std::string const& value)
    {
        names_.insert(name);
        setenv(name.c_str(), value.c_str(), 1);
    }

private:
    static std::size_t indent(std::string const& text) { return std::min(text.find_first_not_of(' '), text.size()); }
    std::vector<Line> parsed(std::size_t& i, std::size_t least)
    {
        std::vector<Line> block;
        std::optional<std::size_t> own;
        while (i < lines_.size()) {
            auto line = lines_[i];
            auto const here = indent(line.text);
            if (here == line.text.size() || line.text[here] == '#') { ++i; continue; }
            if (here < least) break;
            if (!own) own = here;
            if (here != *own) throw Error(name_ + ":" + std::to_string(line.number) + ": the line is indented in another way than the block");
            while (line.text.ends_with(" \\") && i + 1 < lines_.size()) line.text.resize(line.text.size() - 1), line.text += trimmed(lines_[++i].text);
            ++i;
            line.text = trimmed(line.text);
            if (line.text == "sh" || line.text.starts_with("sh ")) {
                auto const margin = i < lines_.size() ? indent(lines_[i].text) : 0;
                for (; i < lines_.size() && (indent(lines_[i].text) > here || trimmed(lines_[i].text).empty()); ++i)
                    line.script += lines_[i].text.substr(std::min(margin, indent(lines_[i].text))) + "\n";
                block.push_back(line);
                continue;
            }
            for (auto at = line.text.find(" :: "); at != std::string::npos; at = line.text.find(" :: ")) {
                block.push_back({line.number, trimmed(line.text.substr(0, at)), {}, {}});
                line.text = trimmed(line.text.substr(at + 4));
            }
            line.block = parsed(i, here + 1);
            block.push_back(line);
        }
        return block;
    }

    void fail(std::string const& what)
    {
        ++failures_;
        if (muted_) return;
        std::string with;
        for (auto const& name : each_) with += (with.empty() ? " with " : ", ") + name + "=" + std::string(std::getenv(name.c_str())).substr(0, 60);
        std::cout << "FAILED: " << name_ << ":" << line_->number << with << ": " << line_->text << "\n    " << what << std::endl;
    }
    /// The status of shell commands; their output goes where `log` is, if it is given.
    static int shell(std::string const& commands, fs::path const& log = {})
    {
        auto const child = fork();
        if (child < 0) throw Error("fork failed");
        if (child == 0) {
            if (!log.empty()) {
                int const to = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
                dup2(to, 1), dup2(to, 2), close(to);
            }
            auto const text = ". \"$tables/common.sh\"\n" + commands;
            execl("/bin/sh", "sh", "-c", text.c_str(), static_cast<char*>(nullptr));
            _exit(127);
        }
        int status = 0;
        while (waitpid(child, &status, 0) < 0) {}
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    static fs::path log() { return fs::path("..") / (fs::current_path().filename().string() + ".log"); }
    /// Variables are replaced, and $(COMMAND) by what it prints.
    std::string expanded(std::string const& text) const
    {
        if (text.find("$(") != std::string::npos) {
            if (shell("cat <<END_OF_TEXT\n" + text + "\nEND_OF_TEXT\n", log()) != 0) throw Error(contents(log()));
            return trimmed(contents(log()));
        }
        std::string all;
        for (std::size_t i = 0; i < text.size();) {
            auto end = i + 1;
            while (text[i] == '$' && end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) || text[end] == '_')) ++end;
            auto const name = text.substr(i + 1, end - i - 1);
            bool const known = text[i] == '$' && names_.contains(name);
            all += known ? std::string(std::getenv(name.c_str())) : text.substr(i, end - i);
            i = end;
        }
        return all;
    }

    void command(std::string const& verb, std::string const& text)
    {
        auto [arguments, pattern] = split(" " + text, " => ");
        int wanted = verb == "run" ? 0 : 2;
        if (verb == "ends") {
            auto const [status, rest] = split(arguments, " ");
            wanted = std::stoi(status), arguments = rest;
        }
        fs::remove("stdout"), fs::remove("stderr");
        auto const before = files_now();
        auto const status = shell("${before:+eval \"$before\"}\nexec timeout -k 5 ${seconds:-120} \"$PROGRAM\" </dev/null >stdout 2>stderr " + arguments, log());
        auto const after = files_now();
        if (!fs::exists("stderr")) return fail(beginning(contents(log())));
        auto const errors = contents("stderr");
        if (status != wanted) return fail("status " + std::to_string(status) + ", not " + std::to_string(wanted) + ": " + beginning(errors));
        auto const error_lines = std::count(errors.begin(), errors.end(), '\n');
        if (verb == "run" && (error_lines > 1 || (!errors.empty() && !matches(errors, "^[^ ].* lacks\\{0,1\\} .* ([0-9,]* [a-z_].*); ."))))
            fail("standard error: " + beginning(errors));
        if (verb == "refuse" || verb == "stop") {
            if (error_lines != 1 || errors.size() >= 1100 || !matches(errors, "^[^(].* (.*); .")) fail("not one line \"problem (why); what to do\": " + beginning(errors));
            if (!matches(errors, expanded(pattern))) fail("another line: " + beginning(errors));
        }
        if (verb == "refuse" && fs::is_regular_file("stdout") && !fs::is_empty("stdout")) fail("standard output: " + beginning(contents("stdout")));
        for (auto const& [name, facts] : before)
            if (verb == "refuse" && (!after.contains(name) || after.at(name) != facts)) fail("a refused run changed " + name);
        for (auto const& [name, facts] : after) {
            if (verb == "refuse" && !before.contains(name)) fail("a refused run left " + name);
            if (name.ends_with(".part") && !before.contains(name)) fail(name + " is left");
            if (!S_ISREG(facts[0]) || (before.contains(name) && before.at(name) == facts)) continue;
            if (name.ends_with(".png") && !contents(name).ends_with("IEND\xae\x42\x60\x82")) fail(name + " is not whole");
            if (name.ends_with(".json")) try { (void)json_values(contents(name)); }
                catch (Error const& error) { fail(name + ": " + error.what()); }
        }
    }
    void statement(std::string const& verb, std::string const& raw)
    {
        if (verb == "run" || verb == "ends" || verb == "refuse" || verb == "stop") return command(verb, raw);
        if (verb == "sh") {
            if (auto const status = shell("set -e\n" + raw + "\n" + line_->script, log()); status != 0)
                fail("status " + std::to_string(status) + ": " + beginning(contents(log())));
            return;
        }
        if (verb == "fails") {
            auto const so_far = failures_;
            bool const was_muted = std::exchange(muted_, true);
            auto const [inner, rest] = split(raw, " ");
            try { statement(inner, rest); }
            catch (Error const&) { ++failures_; }
            muted_ = was_muted;
            bool const failed = failures_ > so_far;
            failures_ = so_far;
            if (!failed) fail("it did not fail");
            return;
        }
        auto const text = expanded(raw);
        auto const all = words(text);
        if (verb == "is") {
            if (auto const wrong = Expression(text).check(); !wrong.empty()) fail(wrong);
        } else if (verb == "has" || verb == "hasnt") {
            auto const [file, pattern] = split(text, " ");
            if (matches(contents(file), pattern) != (verb == "has")) fail((verb == "has" ? "it is not in: " : "it is in: ") + beginning(contents(file)));
        } else if (verb == "same" || verb == "differ") {
            if (all.size() != 2) throw Error("two files are compared");
            auto const a = contents(all[0]), b = contents(all[1]);
            if ((a == b) == (verb == "same")) return;
            if (verb == "differ") return fail("they are equal");
            auto const at = static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
            auto const near = [&](std::string const& s) { return s.substr(std::min(at, s.size()) - std::min<std::size_t>(at, 30), 60); };
            fail(std::to_string(a.size()) + " and " + std::to_string(b.size()) + " bytes differ at byte " + std::to_string(at) + ": " + near(a) + " / " + near(b));
        } else if (verb == "here" || verb == "gone") {
            for (auto const& name : all)
                if (fs::exists(fs::symlink_status(name)) != (verb == "here")) fail(name + (verb == "here" ? " is not there" : " is there"));
        } else throw Error("there is no statement " + verb);
    }
    void run(std::vector<Line> const& lines)
    {
        for (auto const& line : lines) {
            line_ = &line;
            auto const [verb, rest] = split(line.text, " ");
            try {
                if (verb == "each") {
                    auto const [names, list] = split(rest, "=");
                    auto const named = words(names);
                    auto const text = expanded(list);
                    auto const values = text.find('|') == std::string::npos ? words(text) : pieces(text, '|');
                    for (auto const& value : values) {
                        auto parts = named.size() == 1 ? Texts{trimmed(value)} : words(value);
                        if (parts.size() + 1 == named.size()) parts.emplace_back();
                        if (parts.size() < named.size()) throw Error("too few words in " + value);
                        while (parts.size() > named.size()) parts[parts.size() - 2] += " " + parts.back(), parts.pop_back();
                        for (std::size_t n = 0; n < named.size(); ++n) set(named[n], parts[n]), each_.push_back(named[n]);
                        run(line.block);
                        each_.resize(each_.size() - named.size());
                    }
                } else if (verb == "when") {
                    auto const [condition, why] = split(rest, " => ");
                    if (shell(condition, log()) == 0) run(line.block);
                    else if (!why.empty()) std::cout << "skipped: " << why << std::endl;
                } else if (rest.starts_with("= ") || rest == "=") set(verb, expanded(trimmed(rest.substr(1))));
                else {
                    ++done_;
                    statement(verb, rest);
                    run(line.block);
                }
            } catch (Error const& error) {
                line_ = &line;
                fail(error.what());
            }
        }
    }

    std::string name_;
    std::vector<Line> lines_, rows_;
    std::set<std::string> names_;
    Texts each_;
    Line const* line_ = nullptr;
    int done_ = 0, failures_ = 0;
    bool muted_ = false;
};

} // namespace

int main(int argc, char** argv)
{
    if (argc < 2) return 2;
    auto const path = fs::absolute(argv[1]);
    auto folder = (fs::temp_directory_path() / "run_table_XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr) return 2;
    int status = 2;
    try {
        Table table(path);
        for (int i = 2; i < argc; ++i) {
            auto const [name, value] = split(argv[i], "=");
            table.set(name, value.find('/') == std::string::npos ? value : fs::absolute(value).string());
        }
        fs::create_directory(folder + "/work");
        fs::current_path(folder + "/work");
        table.set("work", fs::current_path().string());
        table.set("tables", path.parent_path().string());
        setenv("LC_ALL", "C", 1);
        status = table.run();
    } catch (std::exception const& error) {
        std::cout << "FAILED: " << error.what() << "\n";
    }
    fs::current_path("/");
    std::error_code ignored;
    fs::permissions(folder, fs::perms::owner_all, ignored);
    fs::remove_all(folder, ignored);
    return status;
}
