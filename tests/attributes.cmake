# The attributes of a test file stand in its first line, separated by commas: `// test: optimised, without tsan, cost 20`.
#
#   optimised              compiled at -O2 by GCC even where the preset says -O1: it renders whole maps many times
#   unoptimised BUILD...   compiled at -O0 in these builds, where the others are at -O1: compiling takes longer than running
#                          (in the build asan all files are)
#   without BUILD...       not built in these builds: another file runs the same code there, or it has no threads to watch.
#                          `without test` keeps the test command of README.md short; the same promise has another test there,
#                          and the build ci has this file
#   alone                  is a unit of the compiler of its own, not a part of one (batches.cmake)
#   needs data             asks for real maps, and says "skipped" or takes another map where there are none: label `data`
#   cost N                 runs for about N seconds; ctest begins with what takes longest
#
# BUILD is test, asan or tsan: the value of TILEMESH_TEST_BUILD, which the presets of these names set. The preset ci sets ci: it has every
# file, with the optimisation of test, because both have one folder. The value is empty in all other presets. Any other word is an error.
set(TILEMESH_TEST_BUILD "" CACHE STRING "The build whose attributes apply: test, ci, asan, tsan, or empty")
set_property(CACHE TILEMESH_TEST_BUILD PROPERTY STRINGS "" test ci asan tsan)
if(NOT TILEMESH_TEST_BUILD MATCHES "^(test|ci|asan|tsan)?$")
    message(FATAL_ERROR "TILEMESH_TEST_BUILD cannot be \"${TILEMESH_TEST_BUILD}\" (there is no such build); set test, ci, asan, tsan, or nothing")
endif()
string(REGEX REPLACE "^ci$" "test" tilemesh_optimised_as "${TILEMESH_TEST_BUILD}")

# Sets PREFIX_options (compile options), PREFIX_left_out, PREFIX_without_test, PREFIX_alone, PREFIX_needs_data and PREFIX_cost from the text of a test file.
function(tilemesh_test_attributes source text prefix)
    set(options "")
    if(tilemesh_optimised_as MATCHES "^(test|tsan)$")
        set(options -O1)
    endif()
    set(left_out FALSE)
    set(without_test FALSE)
    set(alone FALSE)
    set(needs_data FALSE)
    set(cost "")
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_FUNCTION_LIST_DIR}" OUTPUT_VARIABLE file)
    if(text MATCHES "^// test: ([^\n]*)\n")
        set(line "${CMAKE_MATCH_1}")
        string(REPLACE ", " ";" attributes "${line}")
        foreach(attribute IN LISTS attributes)
            if(attribute STREQUAL "optimised")
                list(APPEND options "$<$<AND:$<CONFIG:RelWithDebInfo>,$<CXX_COMPILER_ID:GNU>>:-O2>")
            elseif(attribute MATCHES "^(unoptimised|without)(( (test|asan|tsan))+)$")
                set(verb "${CMAKE_MATCH_1}")
                separate_arguments(builds UNIX_COMMAND "${CMAKE_MATCH_2}")
                if(verb STREQUAL "without" AND test IN_LIST builds)
                    set(without_test TRUE)
                endif()
                if(verb STREQUAL "without" AND NOT TILEMESH_TEST_BUILD STREQUAL "" AND TILEMESH_TEST_BUILD IN_LIST builds)
                    set(left_out TRUE)
                elseif(verb STREQUAL "unoptimised" AND NOT tilemesh_optimised_as STREQUAL "" AND tilemesh_optimised_as IN_LIST builds)
                    list(REMOVE_ITEM options -O1)
                endif()
            elseif(attribute STREQUAL "alone")
                set(alone TRUE)
            elseif(attribute STREQUAL "needs data")
                set(needs_data TRUE)
            elseif(attribute MATCHES "^cost ([1-9][0-9]*)$")
                set(cost "${CMAKE_MATCH_1}")
            else()
                message(FATAL_ERROR "tests/${file} has the attribute \"${attribute}\" (its first line says \"// test: ${line}\"); "
                                    "tests/attributes.cmake lists the attributes that there are")
            endif()
        endforeach()
    elseif(text MATCHES "(^|\n)[ \t]*// *[Tt]ests?:")
        message(FATAL_ERROR "tests/${file} has attributes that are not read (they stand in the first line, as \"// test: A, B\"); move them there")
    endif()
    set(${prefix}_options "${options}" PARENT_SCOPE)
    set(${prefix}_left_out "${left_out}" PARENT_SCOPE)
    set(${prefix}_without_test "${without_test}" PARENT_SCOPE)
    set(${prefix}_alone "${alone}" PARENT_SCOPE)
    set(${prefix}_needs_data "${needs_data}" PARENT_SCOPE)
    set(${prefix}_cost "${cost}" PARENT_SCOPE)
endfunction()
