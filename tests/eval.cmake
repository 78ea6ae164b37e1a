superray_add_test(eval_trajectory_test SOURCES eval/trajectory_test.cpp LIBS superray::eval)
superray_add_test(eval_rawlog_source_test SOURCES eval/rawlog_source_test.cpp LIBS superray::eval)
superray_add_test(eval_scan_source_test SOURCES eval/scan_source_test.cpp LIBS superray::eval
                                                                          octomap)
