# One executable per header of libs/eval; the command line has its own.
foreach(name bench_compare bench_engine map_build map_compare map_output octomap_file
             paper_figures progress_meter rawlog_source realtime scan_source simulated_world trajectory)
  superray_add_test(eval_${name}_test SOURCES eval/${name}_test.cpp LIBS superray::eval octomap
                                                                                 nlohmann_json::nlohmann_json)
endforeach()

superray_add_test(eval_cli_test SOURCES eval/cli_test.cpp LIBS superray::eval)
target_compile_definitions(eval_cli_test
                           PRIVATE SUPERRAY_MAP_APP="$<TARGET_FILE:superray-map>")
add_dependencies(eval_cli_test superray-map)

superray_add_test(eval_bench_cli_test SOURCES eval/bench_cli_test.cpp LIBS superray::eval
                                                                           nlohmann_json::nlohmann_json)
target_compile_definitions(eval_bench_cli_test
                           PRIVATE SUPERRAY_BENCH_APP="$<TARGET_FILE:superray-bench>"
                                   SUPERRAY_KERNELS_APP="$<TARGET_FILE:superray-bench-kernels>")
add_dependencies(eval_bench_cli_test superray-bench superray-bench-kernels)
