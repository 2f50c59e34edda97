// A part of tilemesh::compiled: diagrams, pages, video.
#include <tilemesh/report/detail/heat_image_code.hpp>
#include <tilemesh/report/detail/html_code.hpp>
#include <tilemesh/report/detail/plot_code.hpp>
#include <tilemesh/report/detail/resample_code.hpp>
#include <tilemesh/report/detail/stacked_bars_code.hpp>
#include <tilemesh/report/detail/y4m_code.hpp>
