# usage: cmake -DSOURCE=REPOSITORY -DOUTPUT=FILE -DVERSION=0.2.0 -P single_header.cmake
# The library as one file: the licence, the includes of everybody else's headers, then each own header once, before its first user.
# No list may hold text of a header: lists split at semicolons.
cmake_minimum_required(VERSION 3.25)
set(outer_includes "")
set(done "")
set(body "")

function(inline_header name)
    if(name IN_LIST done)
        return()
    endif()
    list(APPEND done "${name}")
    file(READ "${SOURCE}/include/${name}" text)
    string(REGEX MATCHALL "\n#include <[^>\n]*>" includes "\n${text}")
    string(REGEX REPLACE "\n#(include <[^>\n]*>|pragma once)" "" text "\n${text}")
    set(definitions "") # stand behind what they define
    foreach(include IN LISTS includes)
        if(include MATCHES "<(tilemesh/.*_code\\.hpp)>")
            list(APPEND definitions "${CMAKE_MATCH_1}")
        elseif(include MATCHES "<(tilemesh/.*)>")
            inline_header("${CMAKE_MATCH_1}")
        else()
            string(STRIP "${include}" include)
            list(APPEND outer_includes "${include}\n")
        endif()
    endforeach()
    string(APPEND body "\n// ${name}${text}")
    foreach(definition IN LISTS definitions)
        inline_header("${definition}")
    endforeach()
    set(outer_includes "${outer_includes}" PARENT_SCOPE)
    set(done "${done}" PARENT_SCOPE)
    set(body "${body}" PARENT_SCOPE)
endfunction()
inline_header(tilemesh/tilemesh.hpp)

list(SORT outer_includes)
list(REMOVE_DUPLICATES outer_includes)
list(JOIN outer_includes "" outer_includes)
file(READ "${SOURCE}/LICENSE" licence)
string(STRIP "${licence}" licence)
string(REGEX REPLACE "\n([^\n])" "\n// \\1" licence "${licence}")
string(REPLACE "\n\n" "\n//\n" licence "${licence}")
file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT [=[
#pragma once
// tilemesh @VERSION@ in one file. Generated from the headers: change those, not this file. Left out: report/json.hpp
// (needs nlohmann-json), scene/codec_*.hpp (need the libraries of decoders), mpi/ (needs MPI), poplar/ (needs Poplar), mapping/ and slam/ (compile for seconds). Needs C++20, glm and threads: g++ -std=c++20 -pthread.
//
// @licence@

@outer_includes@@body@]=])
