// SPDX-License-Identifier: BSD-3-Clause
/// Seen by the map library, which then does not say that it is loaded.
extern "C" const bool superray_linked_knowingly;
extern "C" const bool superray_linked_knowingly = true;
