#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tilemesh/config.hpp>
#include <tilemesh/scene/detail/json_reader.hpp>
#include <tilemesh/scene/detail/text_input.hpp>
#include <tilemesh/scene/named_camera.hpp>

namespace tilemesh { inline namespace v0_2 { namespace scene::detail {

/// The keys under which camera files describe a lens with distortion (OpenCV's and COLMAP's coefficients).
inline constexpr std::string_view distortion_keys[] = {
    "k1",         "k2",                      "k3",                "k4",          "k5",           "k6",        "p1", "p2",
    "distortion", "distortion_coefficients", "distortion_params", "dist_coeffs", "camera_model", "is_fisheye"};

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
    TILEMESH_HOST bool read_distortion(std::string& model, LensValues& values, std::size_t key, bool* named = nullptr);
    TILEMESH_HOST void read(CameraField<double>& field);
    TILEMESH_HOST JsonPart read(CameraField<std::string>& field); ///< what it began with
    /// Reads an id: an integer of 64 bits, with or without a sign. A name shows it as the file does.
    TILEMESH_HOST void read_id(CameraField<std::string>& id);
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
    TILEMESH_HOST static std::string in_lower_case(std::string text);
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
    TILEMESH_HOST char const* read_number(JsonPart part, double& value);
};

}}} // namespace tilemesh::scene::detail

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/scene/detail/json_values_code.hpp>
#endif
