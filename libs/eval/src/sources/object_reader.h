// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file object_reader.h
/// The objects of an MRPT file one by one.

#include <mrpt/serialization/CSerializable.h>
#include <superray/eval/input_error.h>
#include <superray/maps/compressed_input.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "sources/read_guard.h"

namespace superray {

/// The file ends too early, or an object is of a class that this MRPT does not know: what
/// was read before is whole. Other errors are damage, after which nothing is certain.
class TruncatedInputError : public InputError {
 public:
    using InputError::InputError;
};

/// Opens a gzip, zstd or plain file. \throws InputError
std::unique_ptr<CompressedInput> openInput(const std::string& path);

/// What a position in the input is counted of: " of 1234" for its size, or " of the
/// uncompressed data".
std::string bytesOf(const CompressedInput& file);

/// What failed when MRPT read an object: of the compressed data, or of the object.
/// Says so if a newer MRPT wrote it.
std::string readFailure(CompressedInput& file, const std::exception& error);

/// Whether a file was read before.
enum class FileState : std::uint8_t {
    unknown,  ///< anything may be in it: see ReadGuard
    whole     ///< another reader has read as many objects
};

class ObjectReader {
 public:
    /// \throws InputError
    explicit ObjectReader(const std::string& path, FileState state = FileState::unknown);

    /// nullptr at the end. An object is never null, nor is an observation of a frame.
    /// \throws TruncatedInputError, InputError: file, cause, whole objects before, position
    mrpt::serialization::CSerializable::Ptr next();

    /// Objects that next() gave so far.
    std::uint64_t objects() const { return objects_; }

 private:
    bool readOn();
    mrpt::serialization::CSerializable::Ptr read();
    std::string withPlace(const std::string& why) const;
    [[noreturn]] void fail(const std::string& why) const;
    void keep(const mrpt::serialization::CSerializable::Ptr& object);
    void expand(const mrpt::serialization::CSerializable::Ptr& object);

    std::string path_;
    std::unique_ptr<CompressedInput> file_;
    std::unique_ptr<ReadGuard> guard_;  ///< of files of unknown state
    std::deque<mrpt::serialization::CSerializable::Ptr> pending_;
    std::uint64_t objects_ = 0;
    std::uint64_t start_ = 0;  ///< where the object that was read last begins
};

}  // namespace superray
