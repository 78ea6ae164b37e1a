// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file external_folders.h
/// Where the files are that hold the data of externally stored observations.

#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <string>
#include <vector>

namespace superray {

/// Names of the external files of an observation, as it has them; empty if all is in it.
std::vector<std::string> externalFilesOf(const mrpt::obs::CObservation& observation);

/// The folders that recordings keep such files in: `<name>_Images` and `Images` beside the
/// recording, in any case of letters, and the recording's own folder.
class ExternalFolders {
 public:
    /// \param recording path of the recording; need not exist
    explicit ExternalFolders(const std::string& recording);

    /// The first folder that has the file; empty if none has.
    std::string find(const std::string& file) const;

    /// Makes MRPT look for the files of this observation where they are.
    /// \throws InputError naming the file and the folders if it is in none
    void useFor(const mrpt::obs::CObservation& observation) const;

    const std::vector<std::filesystem::path>& folders() const { return folders_; }

 private:
    std::vector<std::filesystem::path> folders_;
};

}  // namespace superray
