// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/gzip_output.h>

namespace superray {

bool writeGzip(const mrpt::serialization::CSerializable& object, const std::string& path) {
    mrpt::io::CFileGZOutputStream file;
    if (!file.open(path)) return false;
    mrpt::serialization::archiveFrom(file) << object;
    return true;
}

}  // namespace superray
