#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/scene/map.hpp>
#include <tilemesh/splat/camera.hpp>
#include <tilemesh/splat/gaussian.hpp>
#include <vector>

/// Median times of a frame, in ms, and their ratios to that of a pinhole of the same focal lengths: conics on the mesh (`lossless`), and exact
/// rays on tiles with room for the map. In each round, all of them render a view that moves a little, in turn.
struct FrameTimes {
    double pinhole_ms = 0, lens = 0, exact_pinhole = 0, exact_lens = 0;
};
FrameTimes time_frames(tilemesh::scene::Map const& map, tilemesh::splat::Camera const& through_lens, std::uint32_t rounds, unsigned threads);

/// How far J's mean and covariance are from those of samples, over the Gaussians whose mean is in the picture (no dilation): the p99 of the distance
/// of the means in pixels, and of |L^-1 S L^-T - 1| with J's covariance L L^T and that of the samples S. Each Gaussian is pushed through the lens as
/// `samples` points, in antithetic pairs.
struct Moments {
    std::uint64_t gaussians = 0;
    double centre_px = 0, covariance = 0;
};
Moments sample_moments(std::vector<tilemesh::splat::Gaussian> const& gaussians, tilemesh::splat::Camera const& camera, std::uint32_t samples);
