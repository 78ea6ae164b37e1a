// SPDX-License-Identifier: BSD-3-Clause
#include "values/fold_layers.h"

#include <superray/core/detail/cpu_target.h>

#include "values/fold_versions.h"

namespace superray {
namespace {

/// Up to an instruction set; slowest first.
int foldVersions(InstructionSet most, FoldVersion (&versions)[kMaxFoldVersions]) {
    int n = 0;
    versions[n++] = portableFold();
#if defined(__x86_64__)
    versions[n++] = sse2Fold();
    if (most >= InstructionSet::avx2) versions[n++] = avx2Fold();
    if (most >= InstructionSet::avx512) versions[n++] = avx512Fold();
#else
    static_cast<void>(most);
#endif
    return n;
}

}  // namespace

int foldVersions(FoldVersion (&versions)[kMaxFoldVersions]) {
    return foldVersions(bestInstructionSet(), versions);
}

const FoldVersion& foldForThisCpu() {
    static const FoldVersion best = [] {
        FoldVersion versions[kMaxFoldVersions];
        return versions[foldVersions(instructionSet(), versions) - 1];
    }();
    return best;
}

}  // namespace superray
