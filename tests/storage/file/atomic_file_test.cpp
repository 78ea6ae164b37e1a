// SPDX-License-Identifier: BSD-3-Clause
// Outputs: the old file or the new one, whatever happens and whatever the path is.

#include <superray/storage/atomic_file.h>

#include <sys/file.h>

#include <thread>

#include "storage/file/map_file_tools.h"
#include "storage/file/output_trials.h"

namespace superray::test {
namespace {

constexpr std::size_t kLarge = 700000;  // more than one buffer

std::string contentsNumber(int which) {
    return std::string(kLarge, which == 0 ? 'a' : 'b') + std::to_string(which);
}

class AtomicFileTest : public ::testing::Test {
 protected:
    TemporaryFolder folder;
    const std::string path = folder.path + "/file";

    static void put(const std::string& file, const std::string& contents) {
        std::ofstream(file, std::ios::binary) << contents;
    }
    std::string at(const std::string& name) const { return folder.path + "/" + name; }
    static mode_t modeOf(const std::string& file) {
        struct stat info {};
        EXPECT_EQ(::stat(file.c_str(), &info), 0);
        return info.st_mode & 07777;
    }
    static std::string errorOf(const std::string& file) {
        try {
            writeFileAtomically(file, "new");
        } catch (const MapFileError& e) {
            return e.what();
        }
        return "no error";
    }
};

TEST_F(AtomicFileTest, StandsFaultsFullDisksAndKills) {
    const OutputTrials trials(folder.path, "file", [](const std::string& p, int which) {
        writeFileAtomically(p, contentsNumber(which));
    });
    trials.expectUsable();
    trials.failEachCall();
    trials.fillDisk();
    trials.killWriters(1);
}

TEST_F(AtomicFileTest, StreamsStandThemToo) {
    const OutputTrials trials(folder.path, "file", [](const std::string& p, int which) {
        AtomicStream stream(p);
        for (int i = 0; i < 60000; ++i) stream << which << ' ' << i << '\n';
        stream.commit();
    });
    trials.expectUsable();
    trials.failEachCall();
    trials.fillDisk();
    trials.killWriters(2);
}

TEST_F(AtomicFileTest, NothingIsReplacedWithoutCommit) {
    put(path, "old");
    {
        AtomicFile file(path);
        file.write("new", 3);
    }
    EXPECT_EQ(bytesOf(path), "old");
    EXPECT_EQ(folder.entries(), 1);
}

TEST_F(AtomicFileTest, TwoWritersDoNotMix) {
    AtomicFile a(path), b(path);
    const std::string as(kLarge, 'a'), bs(kLarge, 'b');
    a.write(as.data(), as.size());
    b.write(bs.data(), bs.size());
    a.write(as.data(), as.size());
    b.commit();
    EXPECT_EQ(bytesOf(path), bs);
    a.commit();
    EXPECT_EQ(bytesOf(path), as + as);
    EXPECT_EQ(folder.entries(), 1);
}

TEST_F(AtomicFileTest, OthersFilesAreLeftAlone) {
    const std::string digits = "0123456789abcdef";
    for (const char* name : {"file.part", "file.tmp1-0", "file.0.superray-tmp",
                             "file.0123456789abcdeg.superray-tmp"})
        put(at(name), "mine");
    ASSERT_EQ(::mkdir(at("file." + digits + ".superray-tmp").c_str(), 0700), 0);
    put(at("other." + digits + ".superray-tmp"), "mine");
    writeFileAtomically(path, "new");
    EXPECT_EQ(folder.entries(), 7);
    EXPECT_EQ(bytesOf(at("file.part")), "mine");
}

TEST_F(AtomicFileTest, LeftoversOfKilledWritersGo) {
    put(at("file.0123456789abcdef.superray-tmp"), "half");
    AtomicFile living(path);  // made: removes it
    EXPECT_EQ(folder.entries(), 1);
    writeFileAtomically(path, "new");
    EXPECT_EQ(folder.entries(), 2) << "the file of a living writer is gone";
    living.write("last", 4);
    living.commit();
    EXPECT_EQ(bytesOf(path), "last");
    EXPECT_EQ(folder.entries(), 1);
}

TEST_F(AtomicFileTest, ModeIsKept) {
    for (const mode_t mode : {0600, 0640, 0666, 0755, 0202}) {
        put(path, "old");
        ASSERT_EQ(::chmod(path.c_str(), mode), 0);
        writeFileAtomically(path, "new");
        EXPECT_EQ(modeOf(path), mode);
        ASSERT_EQ(::chmod(path.c_str(), 0600), 0);  // 0202 lets only root read it
        EXPECT_EQ(bytesOf(path), "new");
    }
}

TEST_F(AtomicFileTest, NewFilesFollowTheUmask) {
    const mode_t before = ::umask(027);
    writeFileAtomically(path, "new");
    ::umask(before);
    EXPECT_EQ(modeOf(path), 0640u);
}

TEST_F(AtomicFileTest, OwnerIsKept) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
    put(path, "old");
    ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
    ASSERT_EQ(::chown(path.c_str(), 12345, 23456), 0);
    writeFileAtomically(path, "new");
    struct stat info {};
    ASSERT_EQ(::stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_uid, 12345u);
    EXPECT_EQ(info.st_gid, 23456u);
    EXPECT_EQ(modeOf(path), 0640u);
}

TEST_F(AtomicFileTest, RightsDoNotGrowWhereTheGroupCannotBeKept) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root becomes somebody else";
    ASSERT_EQ(::chmod(folder.path.c_str(), 0777), 0);
    put(path, "old");
    ASSERT_EQ(::chmod(path.c_str(), 0666 & ~S_IROTH), 0);  // the group reads, others do not
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        if (::setgid(23456) != 0 || ::setuid(12345) != 0) ::_exit(2);
        ::_exit(errorOf(path) == "no error" ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    struct stat info {};
    ASSERT_EQ(::stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_gid, 23456u);
    EXPECT_EQ(modeOf(path), 0622u) << "only what everybody may";
}

TEST_F(AtomicFileTest, ReadOnlyFilesAreRefused) {
    put(path, "old");
    ASSERT_EQ(::chmod(path.c_str(), 0444), 0);
    EXPECT_NE(errorOf(path).find("read-only"), std::string::npos) << "also for root";
    EXPECT_THROW(checkOutputFile(path), MapFileError);
    EXPECT_EQ(bytesOf(path), "old");
    EXPECT_EQ(folder.entries(), 1);
}

TEST_F(AtomicFileTest, LinksAreFollowed) {
    ASSERT_EQ(::mkdir(at("far").c_str(), 0700), 0);
    put(at("far/target"), "old");
    ASSERT_EQ(::symlink("far/target", at("second").c_str()), 0);
    ASSERT_EQ(::symlink(at("second").c_str(), path.c_str()), 0);
    writeFileAtomically(path, "new");
    EXPECT_EQ(bytesOf(at("far/target")), "new");
    EXPECT_TRUE(std::filesystem::is_symlink(path));
    EXPECT_TRUE(std::filesystem::is_symlink(at("second")));

    ASSERT_EQ(::symlink("far/none", at("dangling").c_str()), 0);
    writeFileAtomically(at("dangling"), "made");
    EXPECT_EQ(bytesOf(at("far/none")), "made");
    EXPECT_EQ(pathBehindLinks(at("dangling")), at("far/none"));
    EXPECT_EQ(pathBehindLinks(path), at("far/target"));
    ASSERT_EQ(::symlink("loop", at("loop").c_str()), 0);
    EXPECT_NE(errorOf(at("loop")), "no error");
    EXPECT_EQ(pathBehindLinks(at("loop")), at("loop"));
    ASSERT_EQ(::symlink("far", at("folder").c_str()), 0);
    EXPECT_NE(errorOf(at("folder")).find("irectory"), std::string::npos);
}

TEST_F(AtomicFileTest, OtherHardLinksKeepTheOldContents) {
    put(path, "old");
    ASSERT_EQ(::link(path.c_str(), at("twin").c_str()), 0);
    writeFileAtomically(path, "new");
    EXPECT_EQ(bytesOf(path), "new");
    EXPECT_EQ(bytesOf(at("twin")), "old");
}

TEST_F(AtomicFileTest, FifosAndDevicesAreWrittenDirectly) {
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    std::string got;
    std::thread reader([&] { got = bytesOf(path); });
    writeFileAtomically(path, contentsNumber(1));
    reader.join();
    EXPECT_EQ(got, contentsNumber(1));
    EXPECT_EQ(folder.entries(), 1);

    checkOutputFile("/dev/null");
    EXPECT_EQ(errorOf("/dev/null"), "no error");
    EXPECT_NE(errorOf("/dev/full").find("No space"), std::string::npos);
    ASSERT_EQ(::symlink("/dev/full", at("link").c_str()), 0);
    EXPECT_NE(errorOf(at("link")).find("No space"), std::string::npos);

    int ends[2] = {-1, -1};
    ASSERT_EQ(::pipe(ends), 0);
    EXPECT_EQ(errorOf("/proc/self/fd/" + std::to_string(ends[1])), "no error");
    char read[4] = {};
    EXPECT_EQ(::read(ends[0], read, 3), 3);
    EXPECT_STREQ(read, "new");
    ::close(ends[0]);
    ::close(ends[1]);
}

TEST_F(AtomicFileTest, UnusualNames) {
    for (const std::string& name : {std::string(255, 'x'), std::string("a b\n\"c"),
                                    std::string("r\xc3\xa9sum\xc3\xa9")}) {
        put(at(name), "old");
        EXPECT_EQ(errorOf(at(name)), "no error");
        EXPECT_EQ(bytesOf(at(name)), "new");
    }
    EXPECT_EQ(folder.entries(), 3);
    EXPECT_NE(errorOf(at(std::string(256, 'x'))), "no error");
    for (const std::string& bad : {std::string(), folder.path, folder.path + "/",
                                   at("none/file"), at("none/"), path + "/file"}) {
        put(path, "a file, no folder");
        EXPECT_NE(errorOf(bad), "no error") << bad;
        EXPECT_THROW(checkOutputFile(bad), MapFileError) << bad;
    }
}

TEST_F(AtomicFileTest, FailedStreamsDoNotCommit) {
    put(path, "old");
    AtomicStream stream(path);
    stream << "new";
    stream.setstate(std::ios::failbit);
    EXPECT_THROW(stream.commit(), MapFileError);
    EXPECT_EQ(bytesOf(path), "old");
}

}  // namespace
}  // namespace superray::test
