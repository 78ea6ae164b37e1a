// superray-map: maps from recorded scans, at the command line.

#include <superray/eval/input_error.h>

#include <iostream>
#include <map>

#include "commands.h"

/// Seen by the map library, which then does not say that it is loaded.
extern "C" const bool superray_linked_knowingly;
extern "C" const bool superray_linked_knowingly = true;

namespace {

constexpr char kDescription[] =
    R"(Exact occupancy maps from recorded scans, by super rays and culling regions.

  superray-map build drive.rawlog -o drive.srmap --resolution 0.1
  superray-map info drive.srmap
  superray-map export drive.srmap drive.ot
  superray-map compare drive.srmap other.ot

'superray-map COMMAND --help' explains a command, with examples.)";

int run(int argc, char** argv) {
    using namespace superray;
    CLI::App app(kDescription, "superray-map");
    app.require_subcommand(1);
    app.set_version_flag("--version", "superray-map " SUPERRAY_VERSION);
    app.get_formatter()->column_width(28);

    const std::map<std::string, Command> commands = {
        {"build", declareBuild(*app.add_subcommand("build", "Make a map from recorded scans"))},
        {"info", declareInfo(*app.add_subcommand("info", "What a map is and holds"))},
        {"export",
         declareExport(*app.add_subcommand("export", "Write a map for other programs"))},
        {"compare", declareCompare(*app.add_subcommand("compare", "How two maps differ"))}};
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {  // --help, --version
        return app.exit(help);
    } catch (const CLI::ParseError& e) {
        throw InputError(std::string(e.what()) + " (see superray-map --help)");
    }
    return commands.at(app.get_subcommands().front()->get_name())();
}

}  // namespace

int main(int argc, char** argv) {
    std::string error;
    try {
        return run(argc, argv);
    } catch (const std::bad_alloc&) {
        error = "out of memory";
    } catch (const std::exception& e) {
        error = superray::oneLineCause(e);
    }
    std::cerr << "superray-map: error: " << error << std::endl;
    return superray::kError;
}
