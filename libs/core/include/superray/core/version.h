// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file version.h
/// The version of all superray libraries and programs. CMake reads it from here.

#define SUPERRAY_VERSION_MAJOR 0
#define SUPERRAY_VERSION_MINOR 2
#define SUPERRAY_VERSION_PATCH 0

/// Major, minor and patch as a text, such as "0.2.0".
#define SUPERRAY_VERSION "0.2.0"
