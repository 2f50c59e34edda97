# cmake -DFUZZER= -DCORPUS= -DWORK= -DRUNS= [-DDICTIONARY=] -P run.cmake
# Runs a libFuzzer program for RUNS inputs, always the same, on a copy of CORPUS below WORK, and prints executions and seconds.
# Fails where an input breaks it; that input then lies in WORK.
if(DICTIONARY)
    set(dictionary "-dict=${DICTIONARY}")
endif()
file(REMOVE_RECURSE "${WORK}")
file(COPY "${CORPUS}/" DESTINATION "${WORK}/corpus")
execute_process(
    COMMAND "${FUZZER}" -runs=${RUNS} -seed=1 -max_len=4096 -rss_limit_mb=2048 -timeout=20 ${dictionary}
        "-artifact_prefix=${WORK}/" "${WORK}/corpus"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(REGEX MATCH "Done ([0-9]+) runs in ([0-9]+) second" done "${output}")
cmake_path(GET FUZZER FILENAME name)
if(NOT result EQUAL 0 OR NOT done)
    message(FATAL_ERROR "${name} ended with ${result}:\n${output}")
endif()
message(STATUS "${name}: ${CMAKE_MATCH_1} executions in ${CMAKE_MATCH_2} seconds")
