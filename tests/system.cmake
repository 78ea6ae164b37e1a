superray_add_test(system_octomap_agreement_test SOURCES system/octomap_agreement_test.cpp
                  LIBS superray::eval superray::storage octomap)
