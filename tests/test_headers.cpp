// SPDX-License-Identifier: BSD-3-Clause
// The target that compiles the common headers of the tests once needs a source.
