// SPDX-License-Identifier: BSD-3-Clause
#include <superray/slam/slam_options.h>

#include <iostream>
#include <memory>

#include "commands.h"

namespace superray {

Command declareOptions(CLI::App& app) {
    auto config = std::make_shared<std::string>();
    app.footer(
        "Examples:\n"
        "  superray-slam options > mine.ini\n"
        "  superray-slam options --config superray-slam-rgbd.ini\n");
    app.add_option("--config", *config, "Options from this file instead of the defaults")
        ->type_name("FILE");
    return [config] {
        TSlamOptions options;
        if (!config->empty()) options.loadFromFile(*config);
        std::cout << options.toText();
        return int{kSuccess};
    };
}

}  // namespace superray
