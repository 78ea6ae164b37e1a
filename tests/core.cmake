foreach(name cell sensor_model ray_bundle ray_line super_rays culling_region equivalence)
  superray_add_test(core_${name}_test SOURCES core/${name}_test.cpp LIBS superray::core)
endforeach()
