foreach(name cell sensor_model ray_bundle ray_line super_rays culling_region update_batch
        large_memory shared_list mask_fill in_turns attempts packed_triple ray_sample
        share_balance parallel walk_kernels horizon equivalence)
  superray_add_test(core_${name}_test SOURCES core/${name}_test.cpp LIBS superray::core)
endforeach()
# Internal headers: kernels that only some processors run, and what they rest on.
foreach(name large_memory shared_list mask_fill in_turns attempts packed_triple
        ray_sample share_balance walk_kernels horizon)
  target_include_directories(core_${name}_test PRIVATE ${PROJECT_SOURCE_DIR}/libs/core/src)
endforeach()

# The same again with the lesser instruction sets (the run above uses the best).
foreach(set portable avx2)
  add_test(NAME core_equivalence_test_${set} COMMAND core_equivalence_test)
  set_tests_properties(core_equivalence_test_${set}
                       PROPERTIES ENVIRONMENT SUPERRAY_INSTRUCTION_SET=${set})
endforeach()
