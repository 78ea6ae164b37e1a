// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_columns.h
/// What a text file of poses says about its columns, and whether they are read so.

#include <cstddef>
#include <string>
#include <vector>

namespace superray {

/// Names of columns, in a heading or in comments before the first row.
class PoseColumns {
 public:
    /// A comment names columns if it has x y z and a rotation (qx qy qz qw, yaw pitch roll, or
    /// rx ry rz) in any order, but one after the other.
    /// \param where names file and line in errors
    void seeComment(const std::string& line, const std::string& where);
    /// A heading of as many names as there are columns names each of them; another one is
    /// taken as a comment.
    void seeHeading(const std::string& line, const std::string& where);

    /// \param read the names of the columns as they are read: t x y z, then the rotation
    /// \throws InputError if the file names another order; names that are not known say
    ///         nothing
    void check(const std::vector<std::string>& read) const;

 private:
    struct Names {
        std::string where;
        std::vector<std::string> words;
    };
    Names heading_;
    std::vector<Names> orders_;  ///< of comments: x y z and a rotation
};

}  // namespace superray
