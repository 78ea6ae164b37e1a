// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The fold loop for each instruction set.

#include "values/fold_layers.h"

namespace superray {

FoldVersion portableFold();
#if defined(__x86_64__)
FoldVersion sse2Fold();    ///< part of x86-64
FoldVersion avx2Fold();    ///< \pre the processor has InstructionSet::avx2
FoldVersion avx512Fold();  ///< the same, avx512
#endif

}  // namespace superray
