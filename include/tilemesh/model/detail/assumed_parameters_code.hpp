#pragma once
#include <cstdint>
#include <string>
#include <tilemesh/machine/spec.hpp>
#include <tilemesh/model/assumed_parameters.hpp>
#include <tilemesh/model/cost_parameters.hpp>
#include <tilemesh/report/table.hpp>

namespace tilemesh { inline namespace v0_2 {

TILEMESH_HOST std::string assumed_text(CostModel const& model)
{
    std::string const word = "assumed";
    std::string text;
    for (auto const& p : model.parameters) {
        if (p.source.rfind(word, 0) != 0) continue;
        text += (text.empty() ? "assumed: " : ", ") + p.name + ' ' + report::thousands(p.value) + ' ' + p.unit;
        if (p.name == "exchange_byte" && p.source.size() > word.size() + 2) text += " (" + p.source.substr(word.size() + 2) + ")";
    }
    return text;
}

}} // namespace tilemesh
