#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "io/report_document.h"
#include "io/report_fields.h"

namespace backsight {
namespace {

using nlohmann::ordered_json;

constexpr const char* kRemedy = "write it anew with `backsight run`";

/// A value and where it stands: the file, and the keys and indices that lead there.
struct Place {
  const ordered_json& json;
  const std::string& file;
  std::string pointer = {};

  Place At(const ordered_json& child, const std::string& key) const {
    return {child, file, pointer + "/" + key};
  }
  [[noreturn]] void Fail(const std::string& found, const std::string& expected) const {
    throw InputError({file + ": " + (pointer.empty() ? "/" : pointer), found, expected, kRemedy});
  }
  [[noreturn]] void FailValue(const std::string& expected) const {
    constexpr std::size_t kLongest = 60;
    std::string text = json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
    Fail(text, expected);
  }
};

template <typename Value>
void Read(const Place& place, Value* value);

void ReadValue(const Place& place, double* value) {
  if (!place.json.is_number()) place.FailValue("a number");
  *value = place.json.get<double>();
}

void ReadValue(const Place& place, bool* value) {
  if (!place.json.is_boolean()) place.FailValue("true or false");
  *value = place.json.get<bool>();
}

template <std::integral Value>
void ReadValue(const Place& place, Value* value) {
  using Limits = std::numeric_limits<Value>;
  const auto expected = [] {
    return fmt::format("a whole number from {} to {}", Limits::min(), Limits::max());
  };
  if (!place.json.is_number_integer()) place.FailValue(expected());
  const bool fits = place.json.is_number_unsigned()
                        ? std::in_range<Value>(place.json.get<std::uint64_t>())
                        : std::in_range<Value>(place.json.get<std::int64_t>());
  if (!fits) place.FailValue(expected());
  *value = place.json.get<Value>();
}

void ReadValue(const Place& place, std::string* value) {
  if (!place.json.is_string()) place.FailValue("text");
  *value = place.json.get<std::string>();
}

template <typename Word, std::size_t n>
void ReadWord(const Place& place, const Word (&words)[n], Word* value) {
  std::string allowed;
  for (const Word word : words) {
    if (place.json == ToString(word)) {
      *value = word;
      return;
    }
    allowed += (allowed.empty() ? "" : ", ") + ToString(word);
  }
  place.FailValue("one of " + allowed);
}

void ReadValue(const Place& place, StationStatus* value) {
  ReadWord(place, kStationStatuses, value);
}
void ReadValue(const Place& place, LinkStatus* value) { ReadWord(place, kLinkStatuses, value); }
void ReadValue(const Place& place, PictureRecord::Kind* value) {
  ReadWord(place, kPictureKinds, value);
}

const ordered_json& List(const Place& place) {
  if (!place.json.is_array()) place.FailValue("a list");
  return place.json;
}

const ordered_json& List(const Place& place, std::size_t size) {
  if (List(place).size() != size) {
    place.Fail(fmt::format("{} values", place.json.size()), fmt::format("{} values", size));
  }
  return place.json;
}

const ordered_json& Object(const Place& place) {
  if (!place.json.is_object()) place.FailValue("an object with keys");
  return place.json;
}

Place Child(const Place& place, const char* key) {
  const auto found = Object(place).find(key);
  if (found == place.json.end()) place.Fail(fmt::format("no key \"{}\"", key), "this key");
  return place.At(*found, key);
}

/// Reads `size` elements; `at(i)` is where the i-th goes.
template <typename At>
void ReadElements(const Place& place, std::size_t size, const At& at) {
  const ordered_json& list = List(place, size);
  for (std::size_t i = 0; i < size; ++i) Read(place.At(list[i], std::to_string(i)), at(i));
}

template <int n>
void ReadValue(const Place& place, Eigen::Matrix<double, n, 1>* value) {
  ReadElements(place, n, [&](std::size_t i) { return &(*value)[static_cast<Eigen::Index>(i)]; });
}

void ReadValue(const Place& place, Matrix6d* value) {
  const ordered_json& rows = List(place, 6);
  for (std::size_t i = 0; i < 6; ++i) {
    Vector6d row;
    Read(place.At(rows[i], std::to_string(i)), &row);
    value->row(static_cast<Eigen::Index>(i)) = row;
  }
}

void ReadValue(const Place& place, RigidTransform* value) {
  Eigen::Vector4d q;
  Read(Child(place, "translation_m"), &value->translation);
  const Place quaternion = Child(place, "quaternion_wxyz");
  Read(quaternion, &q);
  if (!(std::abs(q.norm() - 1.0) < 1e-6)) quaternion.FailValue("a quaternion of length 1");
  value->rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

template <typename Value>
void ReadValue(const Place& place, std::optional<Value>* value) {
  value->reset();
  if (!place.json.is_null()) Read(place, &value->emplace());
}

template <typename Value>
void ReadValue(const Place& place, std::vector<Value>* values) {
  values->resize(List(place).size());
  ReadElements(place, values->size(), [&](std::size_t i) { return &(*values)[i]; });
}

template <typename Value, std::size_t n>
void ReadValue(const Place& place, std::array<Value, n>* values) {
  ReadElements(place, n, [&](std::size_t i) { return &(*values)[i]; });
}

template <typename Value>
void ReadValue(const Place& place, std::vector<std::pair<std::string, Value>>* values) {
  values->clear();
  for (const auto& [key, child] : Object(place).items()) {
    values->emplace_back(key, Value{});
    Read(place.At(child, key), &values->back().second);
  }
}

/// A visitor of VisitFields that reads a JSON object.
class Reader {
 public:
  explicit Reader(const Place& place) : place_(place) { Object(place); }

  template <typename Value>
  void Field(const char* key, Value& value) {
    Read(Child(place_, key), &value);
  }
  template <typename Value>
  void FieldIf(bool /*shown*/, const char* key, Value& value) {
    const Place child = Child(place_, key);
    if (!child.json.is_null()) Read(child, &value);
  }
  void Word(const char* key, bool& value, const char* yes, const char* no) {
    const Place child = Child(place_, key);
    value = child.json == yes;
    if (!value && child.json != no) child.FailValue(fmt::format("{} or {}", yes, no));
  }
  template <typename Function>
  void Derived(const char* /*key*/, const Function& /*function*/) {}

 private:
  const Place& place_;
};

template <typename Value>
void Read(const Place& place, Value* value) {
  if constexpr (requires { ReadValue(place, value); }) {
    ReadValue(place, value);
  } else {
    Reader reader(place);
    VisitFields(reader, *value);
  }
}

/// What no type says, and drawing relies on.
void RequireSensible(const ReportDocument& document, const std::string& path) {
  constexpr std::string_view kBase64 =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=";
  constexpr double kShortest = 1e-6, kFarthest = 1e9;  // metres
  for (std::size_t i = 0; i < document.pictures.size(); ++i) {
    const PictureRecord& picture = document.pictures[i];
    const auto fail = [&](const char* key, const char* found, const char* expected) {
      throw InputError(
          {fmt::format("{}: /pictures/{}/{}", path, i, key), found, expected, kRemedy});
    };
    if (picture.png_base64.find_first_not_of(kBase64) != std::string::npos) {
      fail("png_base64", "other characters", "base64");
    }
    if (picture.width_px < 1) fail("width_px", "no pixels", "at least 1");
    if (picture.height_px < 1) fail("height_px", "no pixels", "at least 1");
    if (!(picture.metres_per_pixel > kShortest && picture.metres_per_pixel < kFarthest)) {
      fail("metres_per_pixel", "no length of a pixel", "1e-6 to 1e9 m");
    }
    if (!(picture.left_top.cwiseAbs().maxCoeff() < kFarthest)) {
      fail("left_top", "a place off the earth", "less than 1e9 m");
    }
  }
  if (document.run.distances && !(document.run.distances->bin_m > kShortest)) {
    throw InputError({path + ": /distances/bin_m", "no width of a bin", "above 1e-6 m", kRemedy});
  }
}

ordered_json Parse(const std::string& text, const std::string& path) {
  try {
    return ordered_json::parse(text);
  } catch (const ordered_json::parse_error& error) {
    throw InputError({fmt::format("{}: byte {}", path, error.byte), "no JSON from here on",
                      "the report.json of a run", kRemedy});
  } catch (const ordered_json::out_of_range& error) {
    throw InputError({path, error.what(), "numbers that a double holds", kRemedy});
  }
}

}  // namespace

ReportDocument ParseReport(const std::string& text, const std::string& path) {
  const ordered_json json = Parse(text, path);
  const Place root{json, path};
  const Place version = Child(root, "schema_version");
  if (version.json != kReportVersion) version.FailValue(std::to_string(kReportVersion));
  ReportDocument document;
  Read(root, &document);
  RequireSensible(document, path);
  return document;
}

}  // namespace backsight
