// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>
#include <superray/eval/output_paths.h>
#include <superray/storage/atomic_file.h>

#include <algorithm>
#include <filesystem>

namespace superray {
namespace {

namespace fs = std::filesystem;

bool isSameFile(const std::string& a, const std::string& b) {
    std::error_code error;
    const auto statusA = fs::status(a, error), statusB = fs::status(b, error);
    if (!fs::exists(statusA) && !fs::exists(statusB))
        return fs::weakly_canonical(pathBehindLinks(a), error) ==
               fs::weakly_canonical(pathBehindLinks(b), error);
    return fs::is_regular_file(statusA) && fs::is_regular_file(statusB) &&
           fs::equivalent(a, b, error);
}

}  // namespace

void checkOutputPath(const std::string& path, const std::vector<std::string>& extensions) {
    const fs::path file(path);
    if (std::find(extensions.begin(), extensions.end(), file.extension()) == extensions.end()) {
        std::string known;
        for (const auto& e : extensions) known += (known.empty() ? "" : ", ") + e;
        throw InputError(path + ": unknown kind of output; its name must end in " + known);
    }
    std::error_code error;
    if (fs::is_directory(file, error)) throw InputError(path + ": is a folder");
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error))
        throw InputError(path + ": the folder " + folder.string() + " does not exist");
    try {
        checkOutputFile(path);
    } catch (const MapFileError& e) {
        throw InputError(e.what());
    }
}

void checkOutputsApart(const std::vector<std::string>& inputs,
                       const std::vector<std::string>& outputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        for (const std::string& input : inputs)
            if (isSameFile(outputs[i], input))
                throw InputError(outputs[i] + ": would overwrite the input " + input);
        for (std::size_t k = 0; k < i; ++k)
            if (isSameFile(outputs[i], outputs[k]))
                throw InputError(outputs[i] + ": would overwrite another output, " +
                                 outputs[k]);
    }
}

}  // namespace superray
