#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The keys under which camera files describe a lens with distortion (OpenCV's and COLMAP's coefficients).
inline constexpr std::string_view distortion_keys[] = {
    "k1",          "k2",           "k3",        "k4", "k5", "k6", "p1", "p2", "distortion", "distortion_coefficients", "distortion_params",
    "dist_coeffs", "camera_model", "is_fisheye"};

/// A field of a camera: whether the file has it, its fault (null: no fault) and its value.
template <class T>
struct CameraField {
    bool there = false;
    char const* fault = nullptr;
    T value{};
};

/// Reads the values of camera files: numbers, texts, vectors and matrices. It skips a value of another type, and notes its fault.
class JsonValues : public JsonReader {
public:
    using JsonReader::JsonReader;

    /// Reads a value under a distortion key. Returns whether it means a lens with distortion: it is, or holds, a number other than 0, true,
    /// or a text that names no pinhole camera. `named`, if not null, gets the same, except that the models whose coefficients stand under keys
    /// of their own (OPENCV) name a pinhole too. `model` gets a camera model that is no perspective.
    /// `values` gets what it says as the value of distortion key `key`.
    bool read_distortion(std::string& model, LensValues& values, std::size_t key, bool* named = nullptr)
    {
        values.given |= 1u << key;
        bool odd = false;
        constexpr std::size_t all = std::size(distortion_keys);
        bool const one = key < values.coefficients.size(), yes_or_no = key + 1 == all, names = key + 2 == all;
        auto* const list = one || yes_or_no || names ? nullptr : &values.lists[key - values.coefficients.size()];
        if (one) values.coefficients[key] = 0;
        else if (yes_or_no) values.fisheye = false;
        else if (names) values.model.clear();
        else list->clear();
        bool bends = false, bends_otherwise = false;
        std::size_t open = 0;
        do {
            JsonPart const part = next();
            if (part == JsonPart::begin_object || part == JsonPart::begin_list) ++open;
            if (part == JsonPart::end_object || part == JsonPart::end_list) --open;
            auto const word = part == JsonPart::text ? in_lower_case(text()) : std::string();
            bool const coefficients = word == "opencv" || word == "full_opencv" || word == "radial" || word == "simple_radial";
            bool const pinhole = word.empty() || word == "none" || word == "pinhole" || word == "simple_pinhole" || word == "perspective";
            bool const bent = (part == JsonPart::number && number() != 0.0) || (part == JsonPart::other && text() == "true");
            if (part == JsonPart::number && one) values.coefficients[key] = number();
            else if (part == JsonPart::number && list != nullptr && (list->size() < 6 || number() != 0.0) && list->size() < 9)
                list->push_back(number());
            if (part == JsonPart::text && names) values.model = word;
            odd = odd || part == JsonPart::begin_object || open > 1 || (part == JsonPart::begin_list && one) ||
                  (part == JsonPart::number && (yes_or_no || names)) || (part == JsonPart::text && !names) ||
                  (part == JsonPart::other && text() == "true" && !yes_or_no);
            if (part == JsonPart::other && text() == "true") values.fisheye = yes_or_no;
            if (part == JsonPart::text && !fault_of_projection(text()).empty()) model = text();
            bends = bends || bent || !pinhole;
            bends_otherwise = bends_otherwise || bent || !(pinhole || coefficients);
        } while (open != 0);
        values.odd = (values.odd & ~(1u << key)) | (odd && bends ? 1u : 0u) << key;
        if (named != nullptr) *named = bends_otherwise;
        return bends;
    }
    void read(CameraField<double>& field)
    {
        field.there = true;
        field.fault = read_number(next(), field.value);
    }
    JsonPart read(CameraField<std::string>& field) ///< what it began with
    {
        JsonPart const part = next();
        field.there = true;
        field.fault = part != JsonPart::text ? "not a string" : !is_plain(text()) ? "not one line of text" : nullptr;
        if (field.fault == nullptr) field.value = text();
        else skip(part);
        return part;
    }
    /// Reads an id: an integer of 64 bits, with or without a sign. A name shows it as the file does.
    void read_id(CameraField<std::string>& id)
    {
        JsonPart const part = next();
        id.there = true;
        id.fault = "not a whole number";
        std::uint64_t natural = 0;
        std::int64_t whole = 0;
        if (part != JsonPart::number) return skip(part);
        if (!parse_number(text(), natural) && !parse_number(text(), whole)) return;
        id.fault = nullptr;
        id.value = text() == "-0" ? "0" : text();
    }
    template <std::size_t N>
    void read_vector(CameraField<std::array<double, N>>& field, char const* fault)
    {
        JsonPart const part = next();
        field.there = true;
        field.fault = fault;
        if (part == JsonPart::begin_list) field.fault = read_numbers<N>(field.value.data(), fault);
        else skip(part);
    }
    template <std::size_t N>
    void read_matrix(CameraField<std::array<double, N * N>>& field, char const* fault)
    {
        JsonPart const part = next();
        field.there = true;
        field.fault = fault;
        if (part != JsonPart::begin_list) return skip(part);
        char const* wrong = nullptr;
        std::array<double, N> none{};
        std::size_t rows = 0;
        for (JsonPart row; (row = next()) != JsonPart::end_list; ++rows) {
            char const* why = fault;
            if (row == JsonPart::begin_list) why = read_numbers<N>(rows < N ? &field.value[N * rows] : none.data(), fault);
            else skip(row);
            if (wrong == nullptr) wrong = why;
        }
        if (rows == N) field.fault = wrong;
    }

private:
    static std::string in_lower_case(std::string text)
    {
        for (auto& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        return text;
    }
    /// Reads a list of `N` numbers after its opening bracket. Returns its fault: `fault` if it does not have `N` items.
    template <std::size_t N>
    char const* read_numbers(double* numbers, char const* fault)
    {
        char const* wrong = nullptr;
        std::size_t count = 0;
        for (JsonPart part; (part = next()) != JsonPart::end_list; ++count) {
            double value = 0.0;
            char const* const why = read_number(part, value);
            if (wrong == nullptr) wrong = why;
            if (count < N) numbers[count] = value;
        }
        return count == N ? wrong : fault;
    }
    /// Reads the rest of a value that starts with `part`, as a number. Returns its fault; null: no fault.
    char const* read_number(JsonPart part, double& value)
    {
        skip(part);
        if (part != JsonPart::number) return "not a number";
        value = number();
        return std::fabs(value) <= largest_number ? nullptr : "not a number within 1e37";
    }
};

}}} // namespace tilemesh::v0_2::scene::detail
