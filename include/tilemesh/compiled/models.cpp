// A part of tilemesh::compiled: cost and energy.
#include <tilemesh/model/detail/any_to_any_code.hpp>
#include <tilemesh/model/detail/assumed_parameters_code.hpp>
#include <tilemesh/model/detail/bottleneck_code.hpp>
#include <tilemesh/model/detail/chips_code.hpp>
#include <tilemesh/model/detail/confidence_code.hpp>
#include <tilemesh/model/detail/cost_model_code.hpp>
#include <tilemesh/model/detail/cost_parameters_code.hpp>
#include <tilemesh/model/detail/energy_code.hpp>
#include <tilemesh/model/detail/energy_range_code.hpp>
#include <tilemesh/model/detail/exchange_code.hpp>
#include <tilemesh/model/detail/hosts_code.hpp>
#include <tilemesh/model/detail/machine_file_code.hpp>
#include <tilemesh/model/detail/network_code.hpp>
#include <tilemesh/model/detail/network_lines_code.hpp>
#include <tilemesh/model/detail/step_costs_code.hpp>
