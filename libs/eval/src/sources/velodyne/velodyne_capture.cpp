// SPDX-License-Identifier: BSD-3-Clause
// The network packets of a Velodyne, one scan a revolution.

#include <mrpt/obs/CObservationVelodyneScan.h>
#include <superray/eval/input_error.h>

#include <array>
#include <cstring>
#include <map>
#include <utility>

#include "sources/folders/frame_source.h"
#include "sources/object_reader.h"
#include "sources/velodyne/pcap_file.h"

namespace superray {
namespace {

using VelodyneScan = mrpt::obs::CObservationVelodyneScan;
using mrpt::obs::VelodyneCalibration;

constexpr std::size_t kBlockBytes = sizeof(VelodyneScan::raw_block_t);
constexpr std::size_t kModelByte = VelodyneScan::PACKET_SIZE - 1;
constexpr std::uint16_t kPositionPort = 8308;  // GPS messages

/// A sensor that can be read without its own calibration file; limits as MRPT's driver has
/// them.
struct Model {
    int id;
    const char* calibration;
    double maxRange;  ///< [m]
};
constexpr std::array<Model, 2> kModels{{{0x22, "VLP16", 120}, {0x21, "HDL32", 70}}};

const Model* modelOf(int id) {
    for (const Model& model : kModels)
        if (model.id == id) return &model;
    return nullptr;
}

std::uint16_t littleEndian(const std::string& bytes, std::size_t at) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    return static_cast<std::uint16_t>(byte(at) | byte(at + 1) << 8);
}
/// [0.01 degree]
std::uint16_t azimuthOf(const std::string& packet, int block = 0) {
    return littleEndian(packet, static_cast<std::size_t>(block) * kBlockBytes + 2);
}

/// The sensor that sent a packet.
using Sender = std::pair<std::uint32_t, std::uint16_t>;  // address, port of the receiver

Sender senderOf(const Datagram& datagram) {
    return {datagram.sender, datagram.port};
}

std::string labelOf(const Sender& sender) {
    std::string text = "VELODYNE_";
    for (int shift = 24; shift >= 0; shift -= 8)
        text += std::to_string(sender.first >> shift & 0xFFu) + (shift > 0 ? "." : "_");
    return text + std::to_string(sender.second);
}

/// By its size, and the bytes that each of its blocks begins with.
bool isVelodynePacket(const Datagram& datagram) {
    if (datagram.port == kPositionPort || datagram.length != VelodyneScan::PACKET_SIZE ||
        datagram.payload.size() < 2)
        return false;
    const auto header = littleEndian(datagram.payload, 0);
    return header == VelodyneScan::UPPER_BANK || header == VelodyneScan::LOWER_BANK;
}

/// What one sensor sent.
struct Revolutions {
    std::vector<Datagram> starts;      ///< first packet of each, without its payload
    std::vector<std::uint32_t> sizes;  ///< packets of each
    std::uint64_t rightChecksums = 0, firstWrongChecksum = 0;
    std::uint64_t firstEarlier = 0;  ///< than the packet before it
    std::uint64_t firstOfOtherModel = 0;
    char model = 0;  ///< of the first packet
    mrpt::Clock::time_point lastTime;
    std::uint16_t lastAzimuth = 0;

    void add(const Datagram& datagram) {
        const std::uint16_t azimuth = azimuthOf(datagram.payload);
        if (starts.empty()) model = datagram.payload[kModelByte];
        if (model != datagram.payload[kModelByte] && firstOfOtherModel == 0)
            firstOfOtherModel = datagram.packet;
        if (datagram.time < lastTime && firstEarlier == 0) firstEarlier = datagram.packet;
        if (startsRevolution(datagram.time, azimuth)) {
            starts.push_back(datagram);
            starts.back().payload = {};
            sizes.push_back(0);
        }
        ++sizes.back();
        lastTime = datagram.time;
        lastAzimuth = azimuth;
        rightChecksums += datagram.checksum == DatagramChecksum::right;
        if (datagram.checksum == DatagramChecksum::wrong && firstWrongChecksum == 0)
            firstWrongChecksum = datagram.packet;
    }

 private:
    /// The azimuth passes zero, as MRPT's driver has it; or the recording paused.
    bool startsRevolution(mrpt::Clock::time_point time, std::uint16_t azimuth) const {
        constexpr double kPause = 0.05;        // [s] packets come at more than 500 Hz
        constexpr double kSlowest = 0.5;       // [s] revolutions take 0.05 to 0.2 s
        constexpr std::uint32_t kMost = 1024;  // packets; 400 are possible
        return starts.empty() || azimuth < lastAzimuth || sizes.back() >= kMost ||
               secondsBetween(lastTime, time) > kPause ||
               secondsBetween(starts.back().time, time) > kSlowest;
    }
};

class Capture {
 public:
    Capture(const std::string& path, const ScanSourceOptions& options) : path_(path) {
        PcapFile file(path);
        try {
            while (const auto datagram = file.next())
                if (isVelodynePacket(*datagram)) add(*datagram);
        } catch (const TruncatedInputError& e) {
            warning_ = e.what();
            if (options.truncation == Truncation::error && sensors_.empty()) throw;
            if (options.truncation == Truncation::error)
                throw InputError(
                    warning_ +
                    "; packets before it are whole (--accept-truncated takes those)");
        }
        choose(options);
    }

    FrameRecording recording() const {
        FrameRecording recording;
        recording.path = path_;
        recording.label = label_;
        for (const auto& entry : sensors_)
            if (entry.first != sender_) recording.otherLabels.push_back(labelOf(entry.first));
        recording.warning = warning_;
        const Revolutions& chosen = sensors_.at(sender_);
        for (std::size_t i = 0; i < chosen.starts.size(); ++i) {
            Frame frame;
            frame.file = path_;
            frame.time = chosen.starts[i].time;
            frame.number = i;
            recording.frames.push_back(frame);
        }
        recording.read = [reader = std::make_shared<PcapFile>(path_), chosen](const Frame& f) {
            return readScan(*reader, chosen.starts[f.number], chosen.sizes[f.number]);
        };
        return recording;
    }

 private:
    void add(const Datagram& datagram) {
        check(datagram);
        sensors_[senderOf(datagram)].add(datagram);
    }

    [[noreturn]] void fail(std::uint64_t packet, const std::string& why) const {
        throw InputError(path_ + ": packet " + std::to_string(packet) + " of a Velodyne " +
                         why);
    }

    void check(const Datagram& datagram) const {
        const std::string& bytes = datagram.payload;
        if (bytes.size() != datagram.length)
            fail(datagram.packet, "was cut to " + std::to_string(bytes.size()) + " of " +
                                      std::to_string(datagram.length) +
                                      " bytes by the capture (tcpdump: -s 0)");
        const int id = static_cast<unsigned char>(bytes[kModelByte]);
        for (int i = 0; i < VelodyneScan::BLOCKS_PER_PACKET; ++i) {
            const auto bank = littleEndian(bytes, static_cast<std::size_t>(i) * kBlockBytes);
            if (bank == VelodyneScan::LOWER_BANK)
                fail(
                    datagram.packet,
                    "is of an HDL-64E, which needs the calibration of its own; convert it with "
                    "MRPT's rawlog-grabber (velodyne.ini: calibration_file, pcap_input)");
            if (bank != VelodyneScan::UPPER_BANK ||
                azimuthOf(bytes, i) >= VelodyneScan::ROTATION_MAX_UNITS)
                fail(datagram.packet, "is damaged: block " + std::to_string(i) +
                                          " has the header " + std::to_string(bank) +
                                          " and the azimuth " +
                                          std::to_string(azimuthOf(bytes, i)) +
                                          "; must be 61183, and below 36000");
        }
        if (modelOf(id) == nullptr)
            fail(datagram.packet,
                 "has the model number " + std::to_string(id) +
                     "; known are 34 (VLP-16, Puck) and 33 (HDL-32E). With a calibration file, "
                     "MRPT's rawlog-grabber may convert it (velodyne.ini)");
    }

    /// The sensor that is asked for, or the only one: nothing tells where several are.
    void choose(const ScanSourceOptions& options) {
        if (sensors_.empty())
            throw InputError(path_ +
                             ": holds no packets of a Velodyne (UDP over IPv4, 1206 "
                             "bytes)" +
                             (warning_.empty() ? "" : "; " + warning_));
        std::string labels;
        int accepted = 0;
        for (const auto& [sender, revolutions] : sensors_) {
            const std::string label = sensors_.size() == 1 ? kLabel : labelOf(sender);
            labels += (labels.empty() ? "" : ", ") + label;
            if (!acceptsLabel(options, label)) continue;
            ++accepted;
            sender_ = sender;
            label_ = label;
        }
        if (accepted != 1)
            throw InputError(path_ + ": holds the packets of " + labels + "; " +
                             (accepted == 0 ? "'" + options.sensorLabel + "' is not among them"
                                            : "choose one of them (--sensor)"));
        // Senders that leave checksums to the network adapter have none that is right.
        const Revolutions& chosen = sensors_.at(sender_);
        if (chosen.rightChecksums > 0 && chosen.firstWrongChecksum > 0)
            fail(chosen.firstWrongChecksum, "is damaged: its UDP checksum is wrong");
        if (chosen.firstOfOtherModel > 0)
            fail(chosen.firstOfOtherModel, "is of another model than the packets before it");
        if (chosen.firstEarlier > 0)
            fail(chosen.firstEarlier,
                 "is earlier than the one before it: its revolutions are not in order. "
                 "'reordercap IN OUT' (package wireshark-common) sorts packets by time");
    }

    static mrpt::obs::CObservation::Ptr readScan(PcapFile& file, const Datagram& start,
                                                 std::uint32_t packets) {
        auto scan = VelodyneScan::Create();
        file.seek(start);
        while (scan->scan_packets.size() < packets) {
            const auto datagram = file.next();
            if (!datagram) throw InputError("the capture became shorter while it was read");
            if (!isVelodynePacket(*datagram) || senderOf(*datagram) != senderOf(start))
                continue;
            VelodyneScan::TVelodyneRawPacket packet;
            static_assert(sizeof packet == VelodyneScan::PACKET_SIZE);
            std::memcpy(static_cast<void*>(&packet), datagram->payload.data(), sizeof packet);
            scan->scan_packets.push_back(packet);
        }
        const Model* model = modelOf(scan->scan_packets.front().velodyne_model_ID);
        scan->calibration = VelodyneCalibration::LoadDefaultCalibration(model->calibration);
        scan->maxRange = model->maxRange;
        scan->originalReceivedTimestamp = start.time;
        return scan;
    }

    static constexpr const char* kLabel = "VELODYNE";

    std::string path_, warning_, label_;
    std::map<Sender, Revolutions> sensors_;
    Sender sender_{};
};

}  // namespace

std::unique_ptr<ScanSource> openVelodyneCapture(const std::string& path,
                                                const ScanSourceOptions& options) {
    return makeFrameSource(Capture(path, options).recording(), options);
}

}  // namespace superray
