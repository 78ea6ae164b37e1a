// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pcap_file.h
/// Network captures of libpcap's classic format, as tcpdump, Wireshark and VeloView write
/// them: their UDP datagrams.

#include <mrpt/core/Clock.h>

#include <cstdint>
#include <optional>
#include <string>

#include "sources/bounded_file.h"

namespace superray {

/// What the checksum of a UDP datagram says.
enum class DatagramChecksum : std::uint8_t { none, right, wrong };

/// A UDP datagram over IPv4.
struct Datagram {
    std::uint64_t packet = 0;  ///< its number in the capture, from 1, as Wireshark shows
    std::uint64_t offset = 0;  ///< of its record in the file [bytes]
    mrpt::Clock::time_point time;
    std::uint32_t sender = 0;  ///< IPv4 address
    std::uint16_t port = 0;    ///< of the receiver
    std::size_t length = 0;    ///< bytes that were sent; payload has fewer if it was cut
    std::string payload;
    DatagramChecksum checksum = DatagramChecksum::none;
};

/// Reads a capture once, from its start. Captures may be of either byte order, with micro- or
/// nanoseconds, of Ethernet (with VLAN tags), of Linux's "any" device, or of bare IP.
class PcapFile {
 public:
    /// \throws InputError if the file is no such capture; names the way out for pcapng
    explicit PcapFile(const std::string& path);

    /// The next UDP datagram; other packets and fragments are left out. Nothing at the end.
    /// \throws TruncatedInputError if the file ends within a packet
    /// \throws InputError if a packet's header cannot be right
    std::optional<Datagram> next();

    /// Goes on at a record. \param datagram that next() gave, of this file
    void seek(const Datagram& datagram);

 private:
    std::uint32_t number(const unsigned char* bytes) const;
    bool nextRecord();
    /// Of the packet that `where` names.
    std::string readPart(std::uint64_t bytes, const std::string& where);
    std::optional<Datagram> datagram() const;

    std::string path_;
    BoundedFile file_;
    bool bigEndian_ = false;
    std::uint32_t ticks_ = 0;  ///< of a second
    std::uint32_t link_ = 0;   ///< LINKTYPE_ of the packets

    // The record that was read last.
    std::uint64_t packets_ = 0, start_ = 0;
    mrpt::Clock::time_point time_;
    std::string bytes_;
};

}  // namespace superray
