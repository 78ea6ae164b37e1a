// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/input_error.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <vector>

#include "sources/clouds/cloud_files.h"
#include "sources/clouds/scalar_field.h"
#include "sources/clouds/sensor_points.h"
#include "sources/file_bytes.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

/// A number; or a list: its length, then as many numbers.
struct Property {
    ScalarField value;
    std::optional<ScalarField> length;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::size_t bytes = 0;  ///< of a record, without lists
    bool hasList = false;
    std::vector<Property> properties;
    std::map<std::string, ScalarField> fields;
    std::map<std::string, std::size_t> columnOf;
};

/// Byte sizes and kinds of PLY's types, by both of their names.
std::optional<ScalarField> typeNamed(const std::string& name) {
    static const std::map<std::string, ScalarField> types = {
        {"char", {ScalarKind::signedInt, 1}},     {"int8", {ScalarKind::signedInt, 1}},
        {"uchar", {ScalarKind::unsignedInt, 1}},  {"uint8", {ScalarKind::unsignedInt, 1}},
        {"short", {ScalarKind::signedInt, 2}},    {"int16", {ScalarKind::signedInt, 2}},
        {"ushort", {ScalarKind::unsignedInt, 2}}, {"uint16", {ScalarKind::unsignedInt, 2}},
        {"int", {ScalarKind::signedInt, 4}},      {"int32", {ScalarKind::signedInt, 4}},
        {"uint", {ScalarKind::unsignedInt, 4}},   {"uint32", {ScalarKind::unsignedInt, 4}},
        {"float", {ScalarKind::real, 4}},         {"float32", {ScalarKind::real, 4}},
        {"double", {ScalarKind::real, 8}},        {"float64", {ScalarKind::real, 8}}};
    const auto found = types.find(name);
    if (found == types.end()) return std::nullopt;
    return found->second;
}

constexpr std::size_t kMostDeclared = 1000;  // elements, properties of one

class PlyReader {
 public:
    explicit PlyReader(const std::string& path) : path_(path), bytes_(readFileBytes(path)) {}

    mrpt::maps::CSimplePointsMap::Ptr read() {
        readHeader();
        auto points = mrpt::maps::CSimplePointsMap::Create();
        for (const Element& element : elements_) {
            const bool isVertex = element.name == "vertex";
            if (isVertex) {
                if (found_) fail("it has a second element vertex");
                for (const char* axis : {"x", "y", "z"})
                    if (element.fields.count(axis) == 0)
                        fail(std::string("its vertices have no ") + axis);
                if (element.hasList) fail("its vertices have a list");
            }
            if (format_ == "ascii")
                readText(element, isVertex ? points.get() : nullptr);
            else if (element.hasList)
                skipLists(element);
            else
                readBinary(element, isVertex ? points.get() : nullptr);
            found_ = found_ || isVertex;
        }
        if (!found_) fail("it has no element vertex");
        if (!isPadding(bytes_, at_)) fail("other data follow its elements");
        points->mark_as_modified();
        return points;
    }

 private:
    [[noreturn]] void fail(const std::string& why) const {
        throw InputError(path_ + ": is not a whole PLY file: " + why);
    }

    std::string nextLine(const char* part) {
        const auto end = bytes_.find('\n', at_);
        if (end == std::string::npos) fail(std::string("its ") + part + " ends early");
        std::string line = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (!line.empty() && line.back() == '\r') line.pop_back();
        return line;
    }

    void readHeader() {
        if (nextLine("header") != "ply") fail("it does not begin with 'ply'");
        for (;;) {
            std::istringstream line(nextLine("header"));
            std::string key;
            line >> key;
            if (key == "end_header") break;
            if (key == "format" && !format_.empty())
                fail("its header has a second line format");
            if (key == "format") line >> format_;
            if (key == "element") {
                Element element;
                if (!(line >> element.name >> element.count)) fail("a bad line 'element'");
                if (elements_.size() == kMostDeclared) fail("it has too many elements");
                elements_.push_back(element);
            }
            if (key == "property") addProperty(line);
        }
        if (format_ != "ascii" && format_ != "binary_little_endian" &&
            format_ != "binary_big_endian")
            fail("unknown format '" + format_ + "'");
    }

    void addProperty(std::istringstream& line) {
        if (elements_.empty()) fail("a property before any element");
        Element& element = elements_.back();
        std::string type, lengthType, name;
        line >> type;
        const bool isList = type == "list";
        if (isList) line >> lengthType >> type;
        line >> name;
        auto field = typeNamed(type);
        if (!field || name.empty()) fail("unknown type of property '" + type + "'");
        if (element.properties.size() == kMostDeclared) fail("it has too many properties");
        Property property{*field, std::nullopt};
        if (isList) {
            element.hasList = true;
            property.length = typeNamed(lengthType);
            if (!property.length || property.length->kind == ScalarKind::real)
                fail("unknown type of a list's length '" + lengthType + "'");
        } else {
            field->offset = element.bytes;
            element.bytes += field->bytes;
            element.columnOf[name] = element.properties.size();
            if (!element.fields.emplace(name, *field).second)
                fail("a second property '" + name + "'");
        }
        element.properties.push_back(property);
    }

    void readText(const Element& element, mrpt::maps::CSimplePointsMap* points) {
        for (std::uint64_t i = 0; i < element.count; ++i) {
            std::string line = nextLine("list of elements");
            if (points == nullptr) continue;
            const auto words = wordsOf(line);
            if (words.size() != element.properties.size())
                fail("vertex " + std::to_string(i + 1) + " has " +
                     std::to_string(words.size()) + " values, must have " +
                     std::to_string(element.properties.size()));
            const auto at = [&](const char* axis) {
                const std::string& word = words[element.columnOf.at(axis)];
                const auto number = parseCoordinate(word);
                if (!number) fail("'" + word + "' is not a number");
                return *number;
            };
            addSensorPoint(*points, at("x"), at("y"), at("z"));
        }
    }

    ByteOrder order() const {
        return format_ == "binary_big_endian" ? ByteOrder::big : ByteOrder::little;
    }

    /// Goes to the end of elements of which each has its own size (faces).
    void skipLists(const Element& element) {
        const auto skip = [&](std::uint64_t count, const ScalarField& each) {
            if (count > (bytes_.size() - at_) / each.bytes)
                fail("it ends early, in a list of " + element.name);
            at_ += count * each.bytes;
        };
        for (std::uint64_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties) {
                double length = 1;
                if (property.length) {
                    const auto at = at_;
                    skip(1, *property.length);
                    length = property.length->read(bytes_.data() + at, order());
                    if (!(length >= 0)) fail("a list of negative length");
                }
                skip(static_cast<std::uint64_t>(length), property.value);
            }
    }

    void readBinary(const Element& element, mrpt::maps::CSimplePointsMap* points) {
        const std::size_t left = bytes_.size() - at_;
        if (element.bytes > 0 && element.count > left / element.bytes)
            fail("it ends early: " + std::to_string(element.count) + " of " + element.name +
                 " do not fit its size");
        if (points == nullptr) {
            at_ += element.count * element.bytes;
            return;
        }
        points->reserve(element.count);
        const ScalarField x = element.fields.at("x"), y = element.fields.at("y"),
                          z = element.fields.at("z");
        for (std::uint64_t i = 0; i < element.count; ++i, at_ += element.bytes) {
            const char* record = bytes_.data() + at_;
            addSensorPoint(*points, x.read(record, order()), y.read(record, order()),
                           z.read(record, order()));
        }
    }

    std::string path_, bytes_, format_;
    std::size_t at_ = 0;
    std::vector<Element> elements_;
    bool found_ = false;
};

}  // namespace

mrpt::maps::CSimplePointsMap::Ptr readPly(const std::string& path) {
    return PlyReader(path).read();
}

}  // namespace superray
