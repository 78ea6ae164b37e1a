// SPDX-License-Identifier: BSD-3-Clause
// gzip, zstd and plain files: whole, in pieces, cut anywhere, changed anywhere.

#include <gtest/gtest.h>
#include <superray/maps/compressed_input.h>
#include <zstd.h>

#include <fstream>
#include <random>

#include "gzip_bytes.h"
#include "maps/test_scans.h"

namespace superray {
namespace {

using test::gzip;

struct Outcome {
    std::string bytes, error;
    bool truncated = false;
    Compression compression = Compression::none;
};

Outcome readAll(const std::string& contents) {
    const test::TempFolder folder;
    const std::string path = folder.file("input");
    std::ofstream(path, std::ios::binary) << contents;
    CompressedInput input(path);
    Outcome outcome;
    char some[700];
    while (const std::size_t count = input.Read(some, sizeof some))
        outcome.bytes.append(some, count);
    EXPECT_TRUE(input.atEnd());
    EXPECT_EQ(input.getPosition(), outcome.bytes.size());
    outcome.error = input.error();
    outcome.truncated = input.truncated();
    outcome.compression = input.compression();
    return outcome;
}

/// Compresses somewhat, but not to nothing.
std::string text(std::size_t size, unsigned seed) {
    std::mt19937 random(seed);
    std::string result(size, ' ');
    for (char& c : result) c = static_cast<char>('a' + random() % 13);
    return result;
}

/// One zstd frame, in many blocks.
std::string zstd(const std::string& plain, int checksum, std::size_t block = 500) {
    ZSTD_CCtx* context = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, checksum);
    std::string result(ZSTD_compressBound(plain.size()) + 20 * (plain.size() / block + 2), 0);
    ZSTD_outBuffer out{result.data(), result.size(), 0};
    for (std::size_t at = 0; at < plain.size(); at += block) {
        ZSTD_inBuffer in{plain.data() + at, std::min(block, plain.size() - at), 0};
        EXPECT_EQ(ZSTD_compressStream2(context, &out, &in, ZSTD_e_flush), 0u);
    }
    ZSTD_inBuffer none{nullptr, 0, 0};
    EXPECT_EQ(ZSTD_compressStream2(context, &out, &none, ZSTD_e_end), 0u);
    ZSTD_freeCCtx(context);
    result.resize(out.pos);
    return result;
}

void expectWhole(const Outcome& outcome, const std::string& plain, Compression compression) {
    EXPECT_TRUE(outcome.bytes == plain) << outcome.bytes.size() << " of " << plain.size();
    EXPECT_EQ(outcome.error, "");
    EXPECT_EQ(outcome.compression, compression);
}

TEST(CompressedInput, ReadsEveryFormatByItsContents) {
    for (const std::size_t size : {0u, 1u, 3u, 5000u, 262144u, 1500000u}) {
        const auto plain = text(size, 1);
        expectWhole(readAll(plain), plain, Compression::none);
        expectWhole(readAll(gzip(plain)), plain, Compression::gzip);
        expectWhole(readAll(zstd(plain, 0, 100000)), plain, Compression::zstd);
        expectWhole(readAll(zstd(plain, 1, 100000)), plain, Compression::zstd);
    }
}

TEST(CompressedInput, MembersAndFramesFollowEachOther) {
    const auto a = text(3000, 1), b = text(400000, 2), c = text(10, 3);
    expectWhole(readAll(gzip(a) + gzip(b) + gzip("") + gzip(c)), a + b + c, Compression::gzip);
    expectWhole(readAll(zstd(a, 0) + zstd(b, 1) + zstd("", 0) + zstd(c, 0)), a + b + c,
                Compression::zstd);
    const std::string skippable("\x50\x2a\x4d\x18\x03\0\0\0abc", 11);
    expectWhole(readAll(zstd(a, 0) + skippable + zstd(c, 0)), a + c, Compression::zstd);
    expectWhole(readAll(gzip(a) + std::string(1000, '\0')), a, Compression::gzip);
}

TEST(CompressedInput, EveryTruncationIsToldAndGivesAPrefix) {
    const auto plain = text(1800, 4);
    for (const auto& whole : {gzip(plain), zstd(plain, 0), zstd(plain, 1)}) {
        ASSERT_GT(whole.size(), 500u);
        std::size_t prefixes = 0;
        for (std::size_t length = 1; length < whole.size(); ++length) {
            const auto outcome = readAll(whole.substr(0, length));
            EXPECT_NE(outcome.error.find("truncated"), std::string::npos) << length;
            EXPECT_TRUE(outcome.truncated) << length;
            EXPECT_EQ(outcome.bytes, plain.substr(0, outcome.bytes.size()));
            prefixes += !outcome.bytes.empty();
        }
        EXPECT_GT(prefixes, 100u);
    }
}

TEST(CompressedInput, ChangedBytesAreDamageWhereThereIsAChecksum) {
    const auto plain = text(3000, 5);
    std::mt19937 random(6);
    int errors = 0;
    for (const auto& whole : {gzip(plain), zstd(plain, 1)})
        for (int i = 0; i < 400; ++i) {
            auto changed = whole;
            changed[random() % changed.size()] ^= static_cast<char>(1u << random() % 8);
            const auto outcome = readAll(changed);
            if (outcome.compression == Compression::none) continue;  // the magic number
            ++errors;
            // Names and times in headers are free; the contents are not.
            if (outcome.error.empty()) {
                EXPECT_TRUE(outcome.bytes == plain);
            }
        }
    EXPECT_GT(errors, 600);
}

TEST(CompressedInput, WithoutAChecksumNothingCrashes) {
    const auto whole = zstd(text(3000, 7), 0);
    std::mt19937 random(8);
    int told = 0;
    for (int i = 0; i < 400; ++i) {
        auto changed = whole;
        for (int k = 0; k < 3; ++k)
            changed[random() % changed.size()] = static_cast<char>(random());
        told += !readAll(changed).error.empty();
    }
    EXPECT_GT(told, 50);
}

TEST(CompressedInput, SaysWhatFollowsTheEnd) {
    const auto plain = text(100, 9);
    for (const auto& whole : {gzip(plain), zstd(plain, 0)}) {
        const auto outcome = readAll(whole + "garbage");
        EXPECT_NE(outcome.error.find("after the end"), std::string::npos) << outcome.error;
        EXPECT_FALSE(outcome.truncated);
        EXPECT_EQ(outcome.bytes, plain);
    }
}

TEST(CompressedInput, RefusesEnormousWindows) {
    // Magic number, descriptor without size or checksum, a window of 2^31 bytes.
    const auto outcome = readAll(std::string("\x28\xb5\x2f\xfd\x00\xa8\x01\x00\x00", 9));
    EXPECT_NE(outcome.error.find("more than 128 MiB"), std::string::npos) << outcome.error;
}

TEST(CompressedInput, BytesCanBePutBack) {
    const test::TempFolder folder;
    std::ofstream(folder.file("input")) << "0123456789";
    CompressedInput input(folder.file("input"));
    std::string some(4, ' ');
    ASSERT_EQ(input.Read(some.data(), 4), 4u);
    input.unread(some.substr(1));
    EXPECT_EQ(input.getPosition(), 1u);
    std::string rest(20, ' ');
    rest.resize(input.Read(rest.data(), 20));
    EXPECT_EQ(rest, "123456789");
    EXPECT_TRUE(input.atEnd());
}

TEST(CompressedInput, NamesFilesThatCannotBeOpened) {
    for (const char* path : {"/no/such/file", "/"}) {
        std::string message;
        try {
            CompressedInput input(path);
        } catch (const std::runtime_error& e) {
            message = e.what();
        }
        EXPECT_EQ(message.find(path), 0u) << message;
    }
}

}  // namespace
}  // namespace superray
