#pragma once
#include "plain_text.hpp"

namespace plain {

struct Gaussian {
    std::uint64_t id;
    std::array<double, 14> values; ///< x y z, colour, opacity, log scales, quaternion w x y z
    std::vector<double> harmonics; ///< red, green, blue of each coefficient
};
struct Map {
    std::vector<Gaussian> gaussians;
    std::uint64_t rejected = 0;
    unsigned degree = 0;
};

/// Reads a map whose bytes are all in memory.
class Ply {
public:
    explicit Ply(std::string const& bytes) : bytes_(bytes) {}

    std::optional<Map> read()
    {
        if (bytes_.substr(0, 3) != "ply" || !read_header()) return {};
        auto const vertex = std::find_if(elements_.begin(), elements_.end(), [](Element const& e) { return e.name == "vertex"; });
        if (vertex == elements_.end() || !find_columns(*vertex)) return {};
        if (column_of(*vertex, "packed_position")) return {};
        for (auto const& element : elements_) {
            if (element.properties.empty()) continue;
            // A row takes at least one byte.
            if (element.count > bytes_.size()) return {};
            for (std::uint64_t row = 1; row <= element.count; ++row) {
                std::vector<double> fields;
                if (!(format_ == "ascii" ? ascii_row(element, &element == &*vertex, fields) : binary_row(element, fields))) return {};
                if (&element == &*vertex) keep(row, fields);
            }
        }
        map_.degree = degree_;
        return map_;
    }

    /// All numbers of a binary file, by element and property; nothing for any other file. The name of a list has "[]" behind it.
    using Table = std::map<std::string, std::vector<double>>;
    std::optional<std::map<std::string, Table>> read_tables()
    {
        if (bytes_.substr(0, 3) != "ply" || !read_header() || format_ == "ascii") return {};
        std::map<std::string, Table> tables;
        for (auto const& element : elements_) {
            // Harmonics belong to the rows before them.
            Table& table = tables[element.name == "sh" && tables.count("vertex") == 0 ? "sh before vertex" : element.name];
            auto const key = [](Property const& p) { return p.name + (p.count_type.empty() ? "" : "[]"); };
            for (auto const& p : element.properties) table[key(p)];
            for (std::uint64_t row = 1; row <= (element.properties.empty() ? 0 : element.count); ++row) {
                std::vector<double> fields;
                if (!binary_row(element, fields)) return {};
                for (std::size_t i = 0; i < fields.size(); ++i) table[key(element.properties[i])].push_back(fields[i]);
            }
        }
        return tables;
    }

private:
    struct Property {
        std::string type, name, count_type; ///< count_type empty: not a list
    };
    struct Element {
        std::string name;
        std::uint64_t count;
        std::vector<Property> properties;
    };

    static std::string type_named(std::string const& name)
    {
        static std::map<std::string, std::string> const names{
            {"char", "i1"}, {"int8", "i1"}, {"uchar", "u1"}, {"uint8", "u1"}, {"short", "i2"}, {"int16", "i2"}, {"ushort", "u2"}, {"uint16", "u2"},
            {"int", "i4"}, {"int32", "i4"}, {"uint", "u4"}, {"uint32", "u4"}, {"float", "f4"}, {"float32", "f4"}, {"double", "f8"}, {"float64", "f8"}};
        auto const at = names.find(name);
        return at == names.end() ? "" : at->second;
    }

    bool read_header()
    {
        std::set<std::string> element_names, property_names;
        for (bool first = true;; first = false) {
            std::size_t const end = bytes_.find('\n', at_);
            if (end == bytes_.npos) return false;
            auto const w = words(bytes_.substr(at_, end - at_), " \t\r");
            at_ = end + 1;
            if (first) {
                if (w.size() != 1 || w[0] != "ply") return false;
                continue;
            }
            if (w.empty() || w[0] == "comment" || w[0] == "obj_info") continue;
            if (w[0] == "end_header") return !format_.empty();
            if (w[0] == "format") {
                if (!format_.empty() || w.size() < 2) return false;
                format_ = w[1];
                if (format_ != "ascii" && format_ != "binary_little_endian" && format_ != "binary_big_endian") return false;
            } else if (w[0] == "element") {
                if (w.size() != 3 || !whole(w[2], 64) || !element_names.insert(w[1]).second) return false;
                elements_.push_back({w[1], *whole(w[2], 64), {}});
                property_names.clear();
            } else if (w[0] == "property") {
                bool const list = w.size() > 1 && w[1] == "list";
                if (elements_.empty() || w.size() != (list ? 5u : 3u)) return false;
                Property const p{type_named(w[w.size() - 2]), w.back(), list ? type_named(w[2]) : ""};
                if (p.type.empty() || (list && (p.count_type.empty() || p.count_type[0] == 'f'))) return false;
                if (!property_names.insert(p.name).second) return false;
                elements_.back().properties.push_back(p);
            } else {
                return false;
            }
        }
    }

    std::optional<std::size_t> column_of(Element const& vertex, std::string const& name) const
    {
        for (std::size_t i = 0; i < vertex.properties.size(); ++i)
            if (vertex.properties[i].name == name) return i;
        return {};
    }
    bool find_columns(Element const& vertex)
    {
        for (char const* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
            auto const column = column_of(vertex, name);
            if (!column || !vertex.properties[*column].count_type.empty()) return false;
            columns_.push_back(*column);
        }
        std::size_t rest = 0;
        for (auto const& p : vertex.properties) rest += p.name.substr(0, 7) == "f_rest_" ? 1 : 0;
        for (unsigned degree = 1; degree <= 100; ++degree) {
            std::size_t const a_channel = (degree + 1) * (degree + 1) - 1;
            if (3 * a_channel != rest) continue;
            unsigned const read = std::min(degree, 3u);
            std::vector<std::size_t> more;
            for (std::size_t k = 0; k < (read + 1) * (read + 1) - 1; ++k)
                for (std::size_t channel = 0; channel < 3; ++channel) {
                    auto const column = column_of(vertex, "f_rest_" + std::to_string(channel * a_channel + k));
                    if (!column || !vertex.properties[*column].count_type.empty()) return true;
                    more.push_back(*column);
                }
            columns_.insert(columns_.end(), more.begin(), more.end());
            degree_ = read;
        }
        return true;
    }

    std::optional<double> binary_value(std::string const& type)
    {
        std::size_t const n = static_cast<std::size_t>(type[1] - '0');
        if (bytes_.size() - at_ < n) return {};
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < n; ++i)
            bits = bits << 8 | static_cast<unsigned char>(bytes_[format_ == "binary_big_endian" ? at_ + i : at_ + n - 1 - i]);
        at_ += n;
        if (type == "f4") {
            float value = 0.0f;
            auto const word = static_cast<std::uint32_t>(bits);
            std::memcpy(&value, &word, 4);
            return value;
        }
        if (type == "f8") {
            double value = 0.0;
            std::memcpy(&value, &bits, 8);
            return value;
        }
        bool const negative = type[0] == 'i' && (bits >> (8 * n - 1)) != 0;
        return negative ? static_cast<double>(bits) - std::ldexp(1.0, static_cast<int>(8 * n)) : static_cast<double>(bits);
    }
    bool binary_row(Element const& element, std::vector<double>& fields)
    {
        for (auto const& p : element.properties) {
            auto const value = binary_value(p.count_type.empty() ? p.type : p.count_type);
            if (!value) return false;
            fields.push_back(*value);
            if (p.count_type.empty()) continue;
            double const bytes = *value * (p.type[1] - '0');
            if (*value < 0 || bytes > static_cast<double>(bytes_.size() - at_)) return false;
            at_ += static_cast<std::size_t>(bytes);
        }
        return true;
    }

    bool ascii_row(Element const& element, bool is_read, std::vector<double>& fields)
    {
        std::vector<std::string> w;
        while (w.empty()) {
            if (at_ >= bytes_.size()) return false;
            std::size_t const end = std::min(bytes_.find('\n', at_), bytes_.size());
            w = words(bytes_.substr(at_, end - at_));
            at_ = end + 1;
        }
        std::size_t next = 0;
        for (std::size_t i = 0; i < element.properties.size(); ++i) {
            if (next == w.size() || w[next].size() > 512) return false;
            std::string const word = w[next++];
            auto const& p = element.properties[i];
            fields.push_back(0.0);
            if (!p.count_type.empty()) {
                auto const count = whole(word, 64);
                if (!count || *count > w.size() - next) return false;
                for (std::uint64_t k = 0; k < *count; ++k)
                    if (w[next++].size() > 512) return false;
            } else if (is_read && std::find(columns_.begin(), columns_.end(), i) != columns_.end()) {
                auto const value = number(word);
                if (!value) return false;
                // As a float if the file says so. A number that rounds to more than the largest float stays a double.
                fields.back() = p.type == "f4" && std::fabs(value->value) < std::ldexp(2.0 - std::ldexp(1.0, -24), 127)
                                    ? static_cast<double>(static_cast<float>(value->value))
                                    : value->value;
            }
        }
        return next == w.size();
    }

    void keep(std::uint64_t row, std::vector<double> const& fields)
    {
        double const largest = static_cast<double>(std::numeric_limits<float>::max());
        Gaussian g{row, {}, {}};
        std::array<double, 14> raw{};
        bool good = true;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            double const value = fields[columns_[i]];
            bool const nan = value != value;
            bool const meant = i == 6 || (i >= 7 && i < 10 && value < 0);
            good = good && !nan && (meant || (value >= -largest && value <= largest));
            if (i < 14) raw[i] = value;
            else g.harmonics.push_back(value);
        }
        double squares = 0.0, longest = 0.0;
        for (std::size_t i = 10; i < 14; ++i) longest = std::max(longest, std::fabs(raw[i]));
        if (!good || longest == 0.0) {
            ++map_.rejected;
            return;
        }
        for (std::size_t i = 10; i < 14; ++i) squares += raw[i] / longest * (raw[i] / longest);
        for (std::size_t i = 0; i < 3; ++i) {
            g.values[i] = raw[i];
            double const colour = 0.28209479 * raw[3 + i] + 0.5;
            g.values[3 + i] = degree_ == 0 ? std::max(colour, 0.0) : colour;
            g.values[7 + i] = std::max(raw[7 + i], -87.0);
        }
        g.values[6] = 1.0 / (1.0 + std::exp(-raw[6]));
        for (std::size_t i = 10; i < 14; ++i) g.values[i] = raw[i] / longest / std::sqrt(squares);
        map_.gaussians.push_back(g);
    }

    std::string const& bytes_;
    std::size_t at_ = 0;
    std::string format_;
    std::vector<Element> elements_;
    std::vector<std::size_t> columns_;
    unsigned degree_ = 0;
    Map map_;
};

} // namespace plain
