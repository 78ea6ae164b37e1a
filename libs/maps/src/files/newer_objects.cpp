// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/newer_objects.h>

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>

namespace superray {
namespace {

using mrpt::serialization::CArchive;

/// Rewrites objects as an older MRPT would have written them. Every object is: length
/// of its class's name + 128, name, version, its data, 0x88.
class Translator {
 public:
    Translator(CompressedInput& file, CArchive& in, CArchive& out)
        : file_(file), in_(in), out_(out) {}

    /// One object, and those in it.
    void object() {
        const std::string header = readHeader();
        // The byte of the length belongs to the name in the file.
        const std::string name = header.substr(0, std::max<std::size_t>(header.size(), 1) - 1);
        const std::string type = name.substr(std::min<std::size_t>(name.size(), 1));
        const int version = header.empty() ? -1 : static_cast<unsigned char>(header.back());
        if (type == "mrpt::obs::CObservation2DRangeScan" && version == 8) {
            begin(name, 7);
            laserScan();
        } else if (type == "mrpt::maps::CSimplePointsMap" && version == 10) {
            begin(name, 10);
            points();
        } else if (type == "mrpt::obs::CObservationPointCloud" && version == 0) {
            begin(name, 0);
            cloud();
        } else if (type == "mrpt::obs::CSensoryFrame" && version == 2) {
            begin(name, 2);
            for (std::uint32_t i = copyNumber<std::uint32_t>(); i > 0; --i) object();
        } else if (type == "mrpt::maps::CSimpleMap" && version == 2) {
            begin(name, 1);
            keyframes();
        } else {
            file_.unread(header);
            out_.WriteObject(in_.ReadObject().get());
            return;
        }
        if (copyNumber<std::uint8_t>() != 0x88)
            throw std::runtime_error("an object lacks its end mark: the data are damaged");
    }

 private:
    /// Length byte, name and version; less if the file ends, or if here is no header.
    std::string readHeader() {
        std::string header(1, '\0');
        if (file_.Read(header.data(), 1) == 0) return {};
        const auto first = static_cast<unsigned char>(header[0]);
        if ((first & 0x80u) == 0) return header;
        const std::size_t rest = (first & 0x7fu) + 1u;
        header.resize(1 + rest);
        header.resize(1 + file_.Read(header.data() + 1, rest));
        return header;
    }

    void begin(const std::string& name, std::uint8_t version) {
        out_.WriteBuffer(name.data(), name.size());
        out_ << version;
    }
    void copy(std::uint64_t bytes) {
        std::array<char, 4096> buffer;
        for (; bytes > 0; bytes -= std::min<std::uint64_t>(bytes, buffer.size())) {
            const auto some =
                static_cast<std::size_t>(std::min<std::uint64_t>(bytes, buffer.size()));
            in_.ReadBuffer(buffer.data(), some);
            out_.WriteBuffer(buffer.data(), some);
        }
    }
    void skip(std::size_t bytes) {
        std::array<char, 64> buffer;
        in_.ReadBuffer(buffer.data(), bytes);
    }
    template <class Number>
    Number copyNumber() {
        const auto number = in_.ReadAs<Number>();
        out_ << number;
        return number;
    }
    void copyText() { copy(copyNumber<std::uint32_t>()); }
    void skipText() {
        const auto length = in_.ReadAs<std::uint32_t>();
        if (length > 64) throw std::runtime_error("a type's name is too long: damaged data");
        skip(length);
    }

    /// Version 8 ends with the duration of the sweep (float).
    void laserScan() {
        copy(4 + 1 + 4);  // aperture, direction, largest range
        object();         // pose of the sensor
        const std::uint64_t rays = copyNumber<std::uint32_t>();
        copy(rays * (4 + 1));                                 // ranges, which of them are valid
        copy(4 + 8 + 4);                                      // error, time, aperture of a beam
        copyText();                                           // label
        copy(8);                                              // pitch
        if (copyNumber<std::uint8_t>() != 0) copy(rays * 4);  // intensities
        skip(4);
    }

    /// Version 1 of the insertion options lacks `disableDeletion`.
    void points() {
        copy(std::uint64_t{copyNumber<std::uint32_t>()} * 3 * 4);  // all x, all y, all z
        object();                                                  // map options
        const auto version = in_.ReadAs<std::uint8_t>();
        if (version > 1) unknownVersion(version);
        out_ << std::uint8_t{0};
        copy(4 + 2);
        if (version == 1)
            out_ << std::uint8_t{1};
        else
            copy(1);
        copy(2 + 4 + 4 + 1);
        expectVersion0();  // likelihood options
        copy(8 + 8 + 4);
        expectVersion0();  // drawing options
        copy(4 + 4 * 4 + 1);
    }
    void expectVersion0() {
        if (const auto version = copyNumber<std::uint8_t>(); version != 0)
            unknownVersion(version);
    }
    [[noreturn]] static void unknownVersion(int version) {
        throw std::runtime_error("unknown serialization version number: '" +
                                 std::to_string(version) + "' of the options of points");
    }

    void cloud() {
        copyText();  // label
        copy(8);     // time
        object();    // pose of the sensor
        const bool external = copyNumber<std::uint8_t>() != 0;
        if (external)
            copyText();  // the file
        else
            object();
    }

    /// Version 2 has a twist after each pose and frame.
    void keyframes() {
        for (std::uint32_t i = copyNumber<std::uint32_t>(); i > 0; --i) {
            object();
            object();
            skipText();  // "std::optional"
            skipText();  // "TTwist3D"
            if (in_.ReadAs<std::uint8_t>() != 0) skip(6 * 8);
        }
    }

    CompressedInput& file_;
    CArchive& in_;
    CArchive& out_;
};

}  // namespace

mrpt::serialization::CSerializable::Ptr readObject(CompressedInput& file) {
    auto in = mrpt::serialization::archiveFrom(file);
    if (kMrptReadsZstd) return in.ReadObject();
    mrpt::io::CMemoryStream translated;
    auto archive = mrpt::serialization::archiveFrom(translated);
    Translator(file, in, archive).object();
    translated.Seek(0);
    return archive.ReadObject();
}

}  // namespace superray
