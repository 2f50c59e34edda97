#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tilemesh/config.hpp>
#include <tilemesh/error.hpp>
#include <tilemesh/joined_threads.hpp>
#include <tilemesh/report/image.hpp>
#include <tilemesh/scene/pose.hpp>
#include <tilemesh/track/pose_update.hpp>

namespace tilemesh { inline namespace v0_2 { namespace track {

/// What a camera does to a picture that was rendered: perfect targets flatter every tracker. The defaults are those of a cheap RGB-D camera
/// indoors. 0 switches a fault off.
struct Spoiling {
    double noise = 0.02;         ///< standard deviation added to each channel, of a white of 1
    bool eight_bits = true;      ///< values are clamped to 0..1 and rounded to 255 levels
    double depth_noise = 0.01;   ///< standard deviation of a depth, relative to it
    double depth_holes = 0.1;    ///< the share of pixels without a depth, which is then 0
    double gain_drift = 0.1;     ///< the gain swings between 1 and 1 minus this
    double shutter = 0.0;        ///< the share of a frame's time for which the shutter is open: motion blur of three poses (`shutter_poses`)
    std::uint64_t seed = 1;
};

/// Throws `Error` for a number that is not finite, negative or too large.
TILEMESH_HOST void check(Spoiling const& s);

/// The gain of frame k: 1 - drift sin^2(k / 10), so a swing takes 31 frames, a second of video.
TILEMESH_HOST double gain_of(Spoiling const& s, std::uint64_t frame);

/// Random bits that depend on nothing but their address: a counter-based generator. The finaliser of splitmix64 (Steele, Lea, Flood 2014)
/// mixes each word of the address into those before.
TILEMESH_HOST std::uint64_t random_bits(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel,
                                        std::uint64_t use) noexcept;

/// A number with mean 0 and variance 1: the sum of twelve uniform numbers, nearly normal and never beyond 6. It is exact in integers, so it
/// is the same with every C library.
TILEMESH_HOST double random_normal(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel,
                                   std::uint64_t use) noexcept;

/// Spoils the picture and the depth of frame `frame`, in place; `depth` may be empty. The gain comes first, then noise, then 8 bits. A depth
/// that is not positive and finite becomes a hole. The result depends on the seed, the frame and the pixel, and not on `threads`.
///
/// Throws `Error` for options that `check` refuses, and for a depth of another size. Cost: about 0.1 microseconds a pixel.
TILEMESH_HOST void spoil(report::Image& picture, report::Plane& depth, std::uint64_t frame, Spoiling const& s,
                         unsigned threads = 1);

/// The three poses of a frame with an open shutter: half of the open time before `at`, `at` itself, and as long after it, on the way from
/// the pose before and to the pose after. Frame times are 1 apart.
TILEMESH_HOST std::array<scene::Pose, 3> shutter_poses(scene::Pose const& before, scene::Pose const& at,
                                                       scene::Pose const& after, double shutter);

/// The mean of pictures of one size, summed in double in their order: motion blur. Throws `Error` for no picture and for different sizes.
TILEMESH_HOST report::Image mean_of(std::span<report::Image const> pictures);

}}} // namespace tilemesh::track

#if !defined(TILEMESH_COMPILED)
#include <tilemesh/track/detail/spoil_code.hpp>
#endif
