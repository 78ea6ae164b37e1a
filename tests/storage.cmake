superray_add_test(storage_occupancy_map_test SOURCES storage/occupancy_map_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_content_digest_test SOURCES storage/content_digest_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_octree_test SOURCES storage/octree_test.cpp
                  LIBS superray::storage octomap)
superray_add_test(storage_octree_threads_test SOURCES storage/octree_threads_test.cpp
                  LIBS superray::storage octomap)
superray_add_test(storage_apply_failure_test SOURCES storage/apply_failure_test.cpp
                  LIBS superray::storage octomap)
superray_add_test(storage_node_arena_test SOURCES storage/node_arena_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_chunked_pool_test SOURCES storage/chunked_pool_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_block_order_test SOURCES storage/block_order_test.cpp
                  LIBS superray::storage)
superray_add_test(storage_fold_layers_test SOURCES storage/fold_layers_test.cpp
                  LIBS superray::storage)
# Internal headers: the inner loop has versions that only some CPUs run, and
# what trees are made of is seen only as speed from outside.
foreach(test storage_fold_layers_test storage_node_arena_test storage_chunked_pool_test
        storage_block_order_test)
  target_include_directories(${test} PRIVATE ${PROJECT_SOURCE_DIR}/libs/storage/src)
endforeach()
superray_add_test(storage_map_file_test SOURCES storage/map_file_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
superray_add_test(storage_map_file_fuzz_test SOURCES storage/map_file_fuzz_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
superray_add_test(storage_map_file_versions_test SOURCES storage/map_file_versions_test.cpp
                  LIBS superray::storage ZLIB::ZLIB)
