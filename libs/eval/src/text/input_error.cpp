// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>

namespace superray {

std::string oneLineCause(const std::exception& error) {
    std::string text = error.what();
    const std::string marker = "Message:";
    if (const auto at = text.rfind(marker); at != std::string::npos) {
        text.erase(0, text.find_first_not_of(' ', at + marker.size()));
    }
    text.erase(std::min(text.find('\n'), text.size()));
    return text.empty() ? "unknown error" : text;
}

}  // namespace superray
