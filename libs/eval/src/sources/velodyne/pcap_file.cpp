// SPDX-License-Identifier: BSD-3-Clause
// A capture is a header of 24 bytes, then records: a header of 16 bytes (seconds, fraction,
// bytes that are in the file, bytes that were sent), and the packet.
//
// Read here rather than by MRPT's CVelodyneScanner, which stamps packets with the time of
// reading, so that no poses fit them.

#include "sources/velodyne/pcap_file.h"

#include <superray/eval/input_error.h>

#include <algorithm>

#include "sources/clock_time.h"
#include "sources/object_reader.h"

namespace superray {
namespace {

constexpr std::size_t kFileHeader = 24, kRecordHeader = 16, kUdpHeader = 8;
/// The largest that libpcap itself reads (MAXIMUM_SNAPLEN) [bytes].
constexpr std::uint32_t kLargestPacket = 262144;

constexpr std::uint16_t kIpv4 = 0x0800, kVlan = 0x8100, kVlanOfProvider = 0x88A8;
constexpr unsigned char kUdp = 17;

/// LINKTYPE_ values of the packets that are read.
enum LinkType : std::uint32_t {
    kEthernet = 1,
    kBareIp = 101,
    kLinuxAny = 113,
    kBareIpv4 = 228,
    kLinuxAny2 = 276
};

const unsigned char* bytesAt(const std::string& text, std::size_t at = 0) {
    return reinterpret_cast<const unsigned char*>(text.data()) + at;
}

/// In the byte order of networks.
std::uint16_t word(const unsigned char* bytes) {
    return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

/// Where the IPv4 header begins; nothing for other packets.
std::optional<std::size_t> ipv4Offset(std::uint32_t link, const std::string& bytes) {
    const auto wordAt = [&](std::size_t at) {
        return at + 2 <= bytes.size() ? word(bytesAt(bytes, at)) : std::uint16_t{0};
    };
    switch (link) {
        case kEthernet: {
            std::size_t type = 12;
            for (int tags = 0; tags < 2; ++tags)
                if (wordAt(type) == kVlan || wordAt(type) == kVlanOfProvider) type += 4;
            return wordAt(type) == kIpv4 ? std::optional(type + 2) : std::nullopt;
        }
        case kLinuxAny:
            return wordAt(14) == kIpv4 ? std::optional<std::size_t>(16) : std::nullopt;
        case kLinuxAny2:
            return wordAt(0) == kIpv4 ? std::optional<std::size_t>(20) : std::nullopt;
        default:
            return 0;
    }
}

/// Of the datagram and its pseudo header. \param ip of `ipBytes` bytes, then UDP
DatagramChecksum checksumOf(const unsigned char* ip, std::size_t ipBytes,
                            std::size_t udpBytes) {
    const unsigned char* udp = ip + ipBytes;
    if (word(udp + 6) == 0) return DatagramChecksum::none;
    std::uint32_t sum = kUdp + static_cast<std::uint32_t>(udpBytes);
    for (std::size_t i = 12; i < 20; i += 2) sum += word(ip + i);  // both addresses
    for (std::size_t i = 0; i + 1 < udpBytes; i += 2) sum += word(udp + i);
    if (udpBytes % 2 == 1) sum += static_cast<std::uint32_t>(udp[udpBytes - 1]) << 8;
    while (sum > 0xFFFF) sum = (sum & 0xFFFF) + (sum >> 16);
    return sum == 0xFFFF ? DatagramChecksum::right : DatagramChecksum::wrong;
}

}  // namespace

PcapFile::PcapFile(const std::string& path) : path_(path), file_(path) {
    std::string header = file_.read(std::min<std::uint64_t>(kFileHeader, file_.size()));
    header.resize(kFileHeader);
    const auto is = [&](std::initializer_list<unsigned char> magic) {
        return std::equal(magic.begin(), magic.end(), bytesAt(header));
    };
    if (is({0x0A, 0x0D, 0x0D, 0x0A}))
        throw InputError(path +
                         ": is a capture in the pcapng format; convert it with "
                         "'editcap -F pcap IN.pcapng OUT.pcap' (package wireshark-common)");
    const bool micro = is({0xD4, 0xC3, 0xB2, 0xA1}), nano = is({0x4D, 0x3C, 0xB2, 0xA1});
    const bool bigMicro = is({0xA1, 0xB2, 0xC3, 0xD4}), bigNano = is({0xA1, 0xB2, 0x3C, 0x4D});
    if (file_.size() < kFileHeader || !(micro || nano || bigMicro || bigNano))
        throw InputError(path + ": is not a network capture of libpcap's format");
    bigEndian_ = bigMicro || bigNano;
    ticks_ = micro || bigMicro ? 1000000 : 1000000000;
    constexpr std::uint32_t kTypeBits = 0x0FFFFFFF;  // the others are of check sequences
    link_ = number(bytesAt(header, 20)) & kTypeBits;
    for (const LinkType known : {kEthernet, kBareIp, kLinuxAny, kBareIpv4, kLinuxAny2})
        if (link_ == known) return;
    throw InputError(path + ": has packets of link type " + std::to_string(link_) +
                     "; known are 1 (Ethernet), 101 and 228 (IP), 113 and 276 (Linux 'any')");
}

std::uint32_t PcapFile::number(const unsigned char* b) const {
    const auto byte = [&](int i) { return std::uint32_t{b[bigEndian_ ? 3 - i : i]}; };
    return byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
}

std::string PcapFile::readPart(std::uint64_t bytes, const std::string& where) {
    try {
        return file_.read(bytes);
    } catch (const TruncatedInputError&) {
        throw TruncatedInputError(where + ": the file ends within it");
    }
}

bool PcapFile::nextRecord() {
    start_ = file_.position();
    if (file_.left() == 0) return false;
    ++packets_;
    const std::string where = path_ + ": packet " + std::to_string(packets_) + ", at byte " +
                              std::to_string(start_) + " of " + std::to_string(file_.size());
    const std::string header = readPart(kRecordHeader, where);
    const std::uint32_t fraction = number(bytesAt(header, 4));
    const std::uint32_t stored = number(bytesAt(header, 8)), sent = number(bytesAt(header, 12));
    if (fraction >= ticks_)
        throw InputError(where + ": is damaged: its time has a fraction of " +
                         std::to_string(fraction) + ", must be below " +
                         std::to_string(ticks_));
    if (stored > kLargestPacket || stored > sent)
        throw InputError(where + ": is damaged: " + std::to_string(stored) + " of " +
                         std::to_string(sent) + " bytes (at most " +
                         std::to_string(kLargestPacket) + " are possible)");
    bytes_ = readPart(stored, where);
    constexpr std::int64_t kNanoseconds = 1'000'000'000;
    time_ = timeOfStamp(number(bytesAt(header)), fraction * (kNanoseconds / ticks_));
    return true;
}

std::optional<Datagram> PcapFile::datagram() const {
    const auto offset = ipv4Offset(link_, bytes_);
    constexpr std::size_t kShortestIp = 20;
    if (!offset || bytes_.size() < *offset + kShortestIp + kUdpHeader) return std::nullopt;
    const unsigned char* ip = bytesAt(bytes_, *offset);
    const std::size_t header = 4 * (ip[0] & 0x0Fu), total = word(ip + 2);
    constexpr std::uint16_t kFragmentBits = 0x3FFF;
    const bool isWhole = (word(ip + 6) & kFragmentBits) == 0;
    if (ip[0] >> 4 != 4 || header < kShortestIp || !isWhole || ip[9] != kUdp ||
        total < header + kUdpHeader || bytes_.size() < *offset + header + kUdpHeader)
        return std::nullopt;
    const unsigned char* udp = ip + header;
    const std::size_t udpBytes = word(udp + 4), start = *offset + header + kUdpHeader;
    if (udpBytes < kUdpHeader || udpBytes > total - header) return std::nullopt;
    Datagram result;
    result.packet = packets_;
    result.offset = start_;
    result.time = time_;
    result.sender = std::uint32_t{word(ip + 12)} << 16 | word(ip + 14);
    result.port = word(udp + 2);
    result.length = udpBytes - kUdpHeader;
    result.payload = bytes_.substr(start, result.length);
    if (result.payload.size() == result.length)
        result.checksum = checksumOf(ip, header, udpBytes);
    return result;
}

std::optional<Datagram> PcapFile::next() {
    while (nextRecord())
        if (auto found = datagram()) return found;
    return std::nullopt;
}

void PcapFile::seek(const Datagram& datagram) {
    file_.seek(datagram.offset);
    packets_ = datagram.packet - 1;
}

}  // namespace superray
