// SPDX-License-Identifier: BSD-3-Clause
#include "sources/object_reader.h"

#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/system/os.h>
#include <superray/maps/newer_objects.h>

namespace superray {

using mrpt::serialization::CSerializable;

namespace {

/// True for what MRPT says of an object whose class it does not know.
bool isOfUnknownClass(const std::string& message) {
    return message.find("is not registered") != std::string::npos;
}

}  // namespace

std::unique_ptr<CompressedInput> openInput(const std::string& path) {
    try {
        return std::make_unique<CompressedInput>(path);
    } catch (const std::runtime_error& e) {
        throw InputError(e.what());
    }
}

std::string bytesOf(const CompressedInput& file) {
    return file.compression() == Compression::none ? " of " + std::to_string(file.fileSize())
                                                   : std::string(" of the uncompressed data");
}

std::string readFailure(CompressedInput& file, const std::exception& error) {
    const bool atEnd = file.atEnd();
    if (!file.error().empty()) return file.error();
    const std::string text = error.what();
    const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
    if (has("unknown serialization version") || isOfUnknownClass(text))
        return oneLineCause(error) + " (written by a newer MRPT than this program's, " +
               mrpt::system::MRPT_getVersion() + "?)";
    return atEnd ? "the file ends inside an object" : oneLineCause(error);
}

ObjectReader::ObjectReader(const std::string& path, FileState state)
    : path_(path), file_(openInput(path)) {
    if (state == FileState::whole) return;
    guard_ = std::make_unique<ReadGuard>(path, [&path]() -> ReadGuard::Step {
        auto ahead = std::make_shared<ObjectReader>(path, FileState::whole);
        return [ahead] {
            const bool more = ahead->readOn();
            ahead->objects_ += ahead->pending_.size();
            ahead->pending_.clear();
            return more;
        };
    });
}

/// Reads what comes next in the file, if anything does.
bool ObjectReader::readOn() {
    if (guard_ && !guard_->next()) return false;
    if (file_->atEnd()) {
        if (!file_->error().empty()) fail(file_->error());
        return false;
    }
    expand(read());
    return true;
}

CSerializable::Ptr ObjectReader::next() {
    while (pending_.empty())
        if (!readOn()) return nullptr;
    auto object = pending_.front();
    pending_.pop_front();
    ++objects_;
    return object;
}

CSerializable::Ptr ObjectReader::read() {
    start_ = file_->getPosition();
    try {
        return readObject(*file_);
    } catch (const std::exception& e) {
        const std::string why = readFailure(*file_, e);
        if (objects_ == 0 && !file_->atEnd())
            throw InputError(path_ + ": is not a rawlog (" + why + ")");
        fail(why);
    }
}

std::string ObjectReader::withPlace(const std::string& why) const {
    return path_ + ": " + why + ", after " + std::to_string(objects_) +
           " whole objects, in the one at byte " + std::to_string(start_) + bytesOf(*file_);
}

void ObjectReader::fail(const std::string& why) const {
    const std::string message = withPlace(why);
    const bool isWholeSoFar =
        file_->error().empty() && (file_->atEnd() || isOfUnknownClass(why));
    if (file_->truncated() || isWholeSoFar) throw TruncatedInputError(message);
    throw InputError(message);
}

void ObjectReader::keep(const CSerializable::Ptr& object) {
    if (!object) throw InputError(withPlace("an object is null"));
    if (const auto* frame = dynamic_cast<const mrpt::obs::CSensoryFrame*>(object.get()))
        for (const auto& part : *frame)
            if (!part)
                throw InputError(withPlace("a sensory frame holds what is no observation"));
    pending_.push_back(object);
}

/// A file may be one CRawlog object instead of a sequence.
void ObjectReader::expand(const CSerializable::Ptr& object) {
    if (auto rawlog = std::dynamic_pointer_cast<mrpt::obs::CRawlog>(object))
        for (const auto& entry : *rawlog) keep(entry);
    else
        keep(object);
}

}  // namespace superray
