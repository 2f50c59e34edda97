# usage: cmake -DFORM=... -DSOURCE=REPOSITORY -DBUILD=ITS_BUILD -DWORK=SCRATCH -DCXX=COMPILER -DGENERATOR=... -P consumer.cmake
# The form mpi also takes -DMPIEXEC=LAUNCHER, -DMPIEXEC_NUMBER=ITS_FLAG and -DMPI_SUFFIX=MPI_EXECUTABLE_SUFFIX.
# One way to get the library, as a stranger would: from nothing, with the stranger's own flags, to the program's output.
cmake_minimum_required(VERSION 3.25)
set(flags -O0 -Wall -Wextra -Wconversion -Wshadow -Werror)
list(JOIN flags " " CMAKE_CXX_FLAGS)
set(here "${CMAKE_CURRENT_LIST_DIR}")
set(prefix "${WORK}/prefix") # what the form `install` makes, for the others
set(work "${WORK}/${FORM}")
file(REMOVE_RECURSE "${work}")
file(MAKE_DIRECTORY "${work}")

function(run)
    execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(configure project)
    run(${CMAKE_COMMAND} -S "${here}/${project}" -B "${work}" -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}"
        "-DCMAKE_CXX_FLAGS=${CMAKE_CXX_FLAGS}" ${ARGN})
endfunction()

# `app` of this form prints what stands in `expected`. `launcher`: a command before it.
function(expect_output expected)
    execute_process(COMMAND ${launcher} "${work}/app" ${ARGN} OUTPUT_VARIABLE printed COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
    file(READ "${here}/${expected}" text)
    if(NOT printed STREQUAL text)
        message(FATAL_ERROR "app prints\n${printed}but ${expected} says\n${text}")
    endif()
endfunction()

# Names of all files below `root`.
function(list_files result root)
    file(GLOB_RECURSE files RELATIVE "${root}" "${root}/*")
    list(SORT files)
    set(${result} "${files}" PARENT_SCOPE)
endfunction()

function(install_into root)
    file(REMOVE_RECURSE "${root}")
    run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${root}")
endfunction()

# All headers are installed below `root`, and nothing else with them.
function(expect_headers root)
    list_files(installed "${root}/include")
    list_files(headers "${SOURCE}/include")
    list(FILTER headers EXCLUDE REGEX "/README\\.md$") # guides are read in the repository
    if(NOT installed STREQUAL headers)
        message(FATAL_ERROR "installed are ${installed}, not ${headers}")
    endif()
endfunction()

function(form_install)
    install_into("${prefix}")
    expect_headers("${prefix}")
    list_files(files "${prefix}/share")
    foreach(file IN LISTS files)
        file(READ "${prefix}/share/${file}" text)
        foreach(path IN ITEMS "${SOURCE}" "${BUILD}" "${prefix}")
            # The path itself, not the end of another: a checkout in /tilemesh is not in "include/tilemesh".
            string(REGEX REPLACE "([][+.*()^$?|\\\\])" "\\\\\\1" pattern "${path}")
            if(text MATCHES "(^|[^A-Za-z0-9_.}-])${pattern}")
                message(FATAL_ERROR "${file} holds ${path}")
            endif()
        endforeach()
    endforeach()
endfunction()

function(form_installed)
    configure(app "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_NO_SYSTEM_FROM_IMPORTED=ON) # warnings of the headers are seen
    run(${CMAKE_COMMAND} --build "${work}")
    expect_output(app/expected.txt)
endfunction()

# The host code compiled once, from the installed sources: the same output.
function(form_compiled)
    configure(compiled "-DCMAKE_PREFIX_PATH=${prefix}")
    run(${CMAKE_COMMAND} --build "${work}" --parallel 2)
    expect_output(app/expected.txt)
endfunction()

function(form_relocated)
    install_into("${WORK}/first_prefix")
    file(REMOVE_RECURSE "${WORK}/second_prefix")
    file(RENAME "${WORK}/first_prefix" "${WORK}/second_prefix")
    configure(small "-DCMAKE_PREFIX_PATH=${WORK}/second_prefix")
    run(${CMAKE_COMMAND} --build "${work}")
    expect_output(small/expected.txt)
endfunction()

# The preset of the README installs the headers where nlohmann-json is missing; a build of everything says what it lacks.
function(form_without_json)
    set(without -G "${GENERATOR}" "-DCMAKE_CXX_COMPILER=${CXX}" -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON)
    execute_process(COMMAND ${CMAKE_COMMAND} -S "${SOURCE}" -B "${work}/all" ${without}
        RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
    string(REGEX REPLACE "[ \n]+" " " error "${error}")
    if(result EQUAL 0 OR NOT error MATCHES "need nlohmann-json .* cmake --preset install")
        message(FATAL_ERROR "without nlohmann-json, a build of everything says (${result}): ${error}")
    endif()
    execute_process(COMMAND ${CMAKE_COMMAND} --preset install -B "${work}/headers" ${without}
        WORKING_DIRECTORY "${SOURCE}" COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
    run(${CMAKE_COMMAND} --install "${work}/headers" --prefix "${work}/prefix")
    expect_headers("${work}/prefix")
endfunction()

function(form_version)
    configure(package "-DCMAKE_PREFIX_PATH=${prefix}")
endfunction()

function(form_json)
    configure(json "-DCMAKE_PREFIX_PATH=${prefix}" -DCMAKE_NO_SYSTEM_FROM_IMPORTED=ON)
    run(${CMAKE_COMMAND} --build "${work}")
    expect_output(json/expected.txt "${here}/json/cameras.json" "${work}/report.json")
    file(READ "${work}/report.json" report)
    string(JSON camera GET "${report}" frames 1 camera)
    if(NOT camera STREQUAL "desk/side")
        message(FATAL_ERROR "the second frame of report.json is of camera ${camera}")
    endif()
endfunction()

# Component mpi, with the MPI of the build: two ranks print what the program of `small` prints on one.
function(form_mpi)
    install_into("${WORK}/mpi_prefix")
    configure(mpi "-DCMAKE_PREFIX_PATH=${WORK}/mpi_prefix" -DCMAKE_NO_SYSTEM_FROM_IMPORTED=ON "-DMPI_EXECUTABLE_SUFFIX=${MPI_SUFFIX}")
    run(${CMAKE_COMMAND} --build "${work}")
    set(launcher ${MPIEXEC} ${MPIEXEC_NUMBER} 2)
    expect_output(small/expected.txt)
endfunction()

# In somebody's project: what must not leak is asked there; nothing is installed with it.
function(form_subdirectory)
    configure(parent "-DTILEMESH=${SOURCE}" ${ARGN})
    run(${CMAKE_COMMAND} --build "${work}")
    expect_output(small/expected.txt)
    run(${CMAKE_COMMAND} --install "${work}" --prefix "${work}/prefix")
    list_files(installed "${work}/prefix")
    if(installed)
        message(FATAL_ERROR "installed with the parent: ${installed}")
    endif()
endfunction()

function(form_fetchcontent)
    form_subdirectory(-DWITH_FETCHCONTENT=ON)
endfunction()

# With the definitions of GLM that programs for Vulkan have.
function(form_plain)
    run(${CXX} -std=c++20 ${flags} -DGLM_FORCE_INTRINSICS -DGLM_FORCE_DEFAULT_ALIGNED_GENTYPES -I "${SOURCE}/include" "${here}/app/main.cpp" "${here}/second_unit.cpp" -pthread -o "${work}/app")
    expect_output(app/expected.txt)
    # With the macros of <windows.h> for min and max: one sentence, and none if they are gone.
    set(unit "#include <algorithm>\n#define min(a, b) ((a) < (b) ? (a) : (b))\n#define max(a, b) ((a) > (b) ? (a) : (b))\n")
    file(WRITE "${work}/macros.cpp" "${unit}#include <tilemesh/tilemesh.hpp>\n")
    execute_process(COMMAND ${CXX} -std=c++20 -Wfatal-errors -I "${SOURCE}/include" -E -o "${work}/macros.ii" "${work}/macros.cpp" RESULT_VARIABLE result ERROR_VARIABLE said)
    if(result EQUAL 0 OR NOT said MATCHES "define NOMINMAX before it")
        message(FATAL_ERROR "min and max as macros: ${result}\n${said}")
    endif()
    file(WRITE "${work}/macros.cpp" "${unit}#undef min\n#undef max\n#include <tilemesh/tilemesh.hpp>\n")
    run(${CXX} -std=c++20 -I "${SOURCE}/include" -E -o "${work}/macros.ii" "${work}/macros.cpp")
endfunction()

function(form_pkgconfig)
    find_program(PKG_CONFIG NAMES pkg-config pkgconf)
    if(NOT PKG_CONFIG)
        message(STATUS "skipped: no pkg-config")
        return()
    endif()
    set(ENV{PKG_CONFIG_PATH} "${prefix}/share/pkgconfig")
    execute_process(COMMAND ${PKG_CONFIG} --cflags --libs tilemesh
        OUTPUT_VARIABLE package_flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(package_flags UNIX_COMMAND "${package_flags}")
    run(${CXX} -std=c++20 ${flags} "${here}/small/main.cpp" ${package_flags} -o "${work}/app")
    expect_output(small/expected.txt)
endfunction()

function(form_single_header)
    run(${CMAKE_COMMAND} --build "${BUILD}" --target single_header)
    file(READ "${BUILD}/single/tilemesh.hpp" single)
    list_files(headers "${SOURCE}/include")
    list(FILTER headers INCLUDE REGEX "\\.hpp$")
    list(FILTER headers EXCLUDE REGEX "report/json(_frame)?\\.hpp$|scene/codec_[a-z]+\\.hpp$|^tilemesh/(mpi|poplar|mapping|slam|splat/map)/")
    foreach(header IN LISTS headers)
        # All of it but its own includes, once.
        file(READ "${SOURCE}/include/${header}" text)
        string(REGEX REPLACE "\n#(include <[^>\n]*>|pragma once)" "" text "\n${text}")
        string(FIND "${single}" "\n// ${header}${text}" first)
        string(FIND "${single}" "${text}" last REVERSE)
        string(LENGTH "\n// ${header}" name_length)
        math(EXPR expected "${first} + ${name_length}")
        if(first EQUAL -1 OR NOT last EQUAL expected)
            message(FATAL_ERROR "the single header does not hold ${header} once; is it missing from tilemesh.hpp?")
        endif()
    endforeach()
    foreach(absent IN ITEMS "#include <tilemesh" "#include <nlohmann" "#include <mpi" "#include <poplar" "\n#pragma once\n")
        string(FIND "${single}" "${absent}" position)
        if(NOT position EQUAL -1)
            message(FATAL_ERROR "the single header holds ${absent}")
        endif()
    endforeach()
    file(COPY "${BUILD}/single/tilemesh.hpp" DESTINATION "${work}/tilemesh")
    run(${CXX} -std=c++20 ${flags} -I "${work}" "${here}/app/main.cpp" "${here}/second_unit.cpp" -pthread -o "${work}/app")
    expect_output(app/expected.txt)
endfunction()

cmake_language(CALL form_${FORM})
