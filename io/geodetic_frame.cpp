#include "io/geodetic_frame.h"

#include <fmt/format.h>
#include <proj.h>
#include <proj_experimental.h>

#include <Eigen/Geometry>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>
#include <numbers>

#include "io/vertical_geoid.h"

namespace backsight {
namespace {

template <auto destroy>
struct Destroyer {
  template <class T>
  void operator()(T* object) const {
    destroy(object);
  }
};
using Context = std::unique_ptr<PJ_CONTEXT, Destroyer<proj_context_destroy>>;
using Object = std::unique_ptr<PJ, Destroyer<proj_destroy>>;
using ObjectList = std::unique_ptr<PJ_OBJ_LIST, Destroyer<proj_list_destroy>>;
using OperationFactory = std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT,
                                         Destroyer<proj_operation_factory_context_destroy>>;

/// PROJ's own messages add nothing to ours.
void IgnoreLog(void*, int, const char*) {}

Context MakeContext() {
  Context context(proj_context_create());
  proj_log_func(context.get(), nullptr, IgnoreLog);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

Object FindCrs(PJ_CONTEXT* context, const std::string& name, const std::string& where) {
  Object crs(proj_create(context, name.c_str()));
  if (crs && proj_is_crs(crs.get()) != 0) return crs;
  throw InputError({where, name, "a coordinate reference system that PROJ knows",
                    "look it up with: projinfo " + name});
}

/// Mixed units would be read wrongly from the merged clouds.
void RequireMetres(PJ_CONTEXT* context, const PJ* crs, const std::string& where) {
  const Object system(proj_crs_get_coordinate_system(context, crs));
  const int axes = proj_cs_get_axis_count(context, system.get());
  for (int axis = 0; axis < axes; ++axis) {
    double metres = 1.0;
    const char* unit = "";
    proj_cs_get_axis_info(context, system.get(), axis, nullptr, nullptr, nullptr, &metres, &unit,
                          nullptr, nullptr);
    if (metres == 1.0) continue;
    throw InputError({where, fmt::format("{} counts in {}", proj_get_name(crs), unit),
                      "a system in metres", "give control in a system in metres"});
  }
}

Object FindHorizontal(PJ_CONTEXT* context, const std::string& name, const std::string& where) {
  Object crs = FindCrs(context, name, where);
  if (proj_get_type(crs.get()) == PJ_TYPE_PROJECTED_CRS) {
    RequireMetres(context, crs.get(), where);
    return crs;
  }
  throw InputError({where,
                    fmt::format("{} ({}), which is not projected", name, proj_get_name(crs.get())),
                    "a projected coordinate reference system, like EPSG:25832",
                    "give heights under crs.vertical, and no geographic or compound system here"});
}

Object FindVertical(PJ_CONTEXT* context, const std::string& name, const std::string& where) {
  Object crs = FindCrs(context, name, where);
  if (proj_get_type(crs.get()) == PJ_TYPE_VERTICAL_CRS) {
    RequireMetres(context, crs.get(), where);
    return crs;
  }
  throw InputError({where,
                    fmt::format("{} ({}), which is not vertical", name, proj_get_name(crs.get())),
                    "a vertical coordinate reference system, like EPSG:7837",
                    "leave crs.vertical out where heights are ellipsoidal"});
}

/// National heights may lead through the geoid of another datum and back, to a decimetre or better
/// (LV95 with LN02 does). Where that way is only known to more than half a metre, the datums do not
/// belong together. PROJ names a chain by its links: grid -> geographic, and one for the heights.
bool MixesDatums(PJ_CONTEXT* context, const PJ* operation) {
  const std::string chain = proj_get_name(operation);
  const std::size_t first = chain.find(" + ");
  if (first == std::string::npos || chain.find(" + ", first + 3) == std::string::npos) return false;
  constexpr double kKnown = 0.5;
  const double accuracy_m = proj_coordoperation_get_accuracy(context, operation);
  return accuracy_m > kKnown;
}

struct Grids {
  std::string used;
  std::string missing;
};

Grids GridsOf(PJ_CONTEXT* context, const PJ* operation) {
  Grids grids;
  const int count = proj_coordoperation_get_grid_used_count(context, operation);
  for (int i = 0; i < count; ++i) {
    const char* name = "";
    const char* url = "";
    int available = 0;
    proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, &url, nullptr,
                                      nullptr, &available);
    grids.used += (grids.used.empty() ? "" : ", ") + std::string(name);
    if (available != 0) continue;
    const bool known = url != nullptr && *url != '\0';
    grids.missing += (grids.missing.empty() ? "" : ", ") + std::string(name) +
                     (known ? fmt::format(" ({})", url) : "");
  }
  return grids;
}

/// "EPSG:3855", however the project file wrote it.
std::string CodeOf(const PJ* crs) {
  const char* authority = proj_get_id_auth_name(crs, 0);
  const char* code = proj_get_id_code(crs, 0);
  return authority == nullptr || code == nullptr ? "" : fmt::format("{}:{}", authority, code);
}

/// Names the files, and the folders that are searched for them.
[[noreturn]] void RefuseMissingGrid(const std::string& where, const std::string& name,
                                    const std::string& grids, const std::string& vertical) {
  const char* searched = proj_info().searchpath;
  std::string remedy = fmt::format(
      "put a GeoTIFF or GTX file under this very name into a folder of PROJ's grids ({}), or name "
      "its folder in PROJ_DATA",
      searched == nullptr || *searched == '\0' ? "/usr/share/proj" : searched);
  const std::vector<std::string> geoids = VerticalGeoid::FilesFor(vertical);
  if (!geoids.empty()) {
    remedy += fmt::format(
        "; or put the geoid file {} of GeographicLib into {}, or set GEOGRAPHICLIB_GEOID_PATH to "
        "its folder",
        fmt::join(geoids, " or "), VerticalGeoid::Folder());
  }
  throw InputError(
      {where, fmt::format("{} needs a grid that is not installed: {}", name, grids), "", remedy});
}

[[noreturn]] void RefuseHeights(const std::string& where, const std::string& name,
                                const std::string& why) {
  throw InputError(
      {where, fmt::format("{}: {}", name, why),
       "heights that lead to the ellipsoid of the horizontal system's own datum",
       "give crs.vertical of that datum, or leave it out and give ellipsoidal heights"});
}

/// The best operation between both systems, whether or not its grids are there: a worse one is not
/// taken in its place.
Object BestOperation(PJ_CONTEXT* context, const PJ* source, const PJ* target,
                     const std::string& where) {
  const std::string name = proj_get_name(source);
  const OperationFactory factory(proj_create_operation_factory_context(context, nullptr));
  proj_operation_factory_context_set_grid_availability_use(context, factory.get(),
                                                           PROJ_GRID_AVAILABILITY_IGNORED);
  proj_operation_factory_context_set_spatial_criterion(context, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  const ObjectList list(proj_create_operations(context, source, target, factory.get()));
  Object operation(list && proj_list_get_count(list.get()) > 0
                       ? proj_list_get(context, list.get(), 0)
                       : nullptr);
  if (!operation) RefuseHeights(where, name, "PROJ knows no way to ellipsoidal heights");
  if (proj_coordoperation_has_ballpark_transformation(context, operation.get()) != 0) {
    RefuseHeights(where, name, "PROJ could only guess the way to ellipsoidal heights");
  }
  if (MixesDatums(context, operation.get())) {
    RefuseHeights(
        where, name,
        fmt::format("its parts have different datums ({})", proj_get_name(operation.get())));
  }
  return operation;
}

/// Where a CRS is used, degrees; west may be greater than east, across the antimeridian.
struct Area {
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;
  std::string name;

  bool Holds(double latitude, double longitude) const {
    constexpr double kMargin = 3.0;  // networks reach a little beyond, as zones do
    const double width = std::fmod(east - west + 360.0, 360.0);
    const double from_west = std::fmod(longitude - west + kMargin + 720.0, 360.0);
    const bool all_around = width + 2.0 * kMargin >= 360.0 || east - west >= 360.0;
    return (all_around || from_west <= width + 2.0 * kMargin) && latitude >= south - kMargin &&
           latitude <= north + kMargin;
  }
};

std::optional<Area> AreaOf(PJ_CONTEXT* context, const PJ* crs) {
  constexpr double kUnknown = -1000.0;
  Area area;
  const char* name = nullptr;
  const int known =
      proj_get_area_of_use(context, crs, &area.west, &area.south, &area.east, &area.north, &name);
  if (known == 0 || area.west == kUnknown || area.south == kUnknown) return std::nullopt;
  area.name = name == nullptr ? "" : name;
  return area;
}

}  // namespace

struct GeodeticFrame::Parts {
  Context context = MakeContext();
  Object operation;                      // CRS -> longitude, latitude (degrees), ellipsoidal height
  std::unique_ptr<VerticalGeoid> geoid;  // null: the operation knows the heights
  std::string name, wkt, heights, where;
  std::unique_ptr<GeographicLib::Geocentric> ellipsoid;
  std::unique_ptr<GeographicLib::LocalCartesian> local;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double convergence_deg = 0.0;
  double point_scale = 1.0;
  std::optional<Area> area;  // of the horizontal system

  /// Longitude, latitude; nothing where the way there and back does not close.
  std::optional<Eigen::Vector2d> PlaceOf(const Eigen::Vector3d& crs) const {
    constexpr double kSame = 1e-3;
    proj_errno_reset(operation.get());
    const PJ_COORD in = proj_coord(crs.x(), crs.y(), 0.0, HUGE_VAL);
    const PJ_COORD there = proj_trans(operation.get(), PJ_FWD, in);
    const PJ_COORD back = proj_trans(operation.get(), PJ_INV, there);
    const double gap = std::hypot(back.xyz.x - crs.x(), back.xyz.y - crs.y());
    if (proj_errno(operation.get()) != 0 || !(gap <= kSame)) return std::nullopt;
    return Eigen::Vector2d(there.xyz.x, there.xyz.y);
  }

  Eigen::Vector3d Convert(const Eigen::Vector3d& from, PJ_DIRECTION direction,
                          std::string_view frame) const {
    proj_errno_reset(operation.get());
    const double undulation = direction == PJ_INV ? UndulationAt(from) : 0.0;
    const PJ_COORD in = proj_coord(from.x(), from.y(), from.z() - undulation, HUGE_VAL);
    const PJ_COORD out = proj_trans(operation.get(), direction, in);
    Eigen::Vector3d result(out.xyz.x, out.xyz.y, out.xyz.z);
    if (proj_errno(operation.get()) != 0 || !result.allFinite()) RefusePlace(frame, from);
    if (direction == PJ_FWD) result.z() += UndulationAt(result);
    return result;
  }

  /// Of the geoid file above the ellipsoid at longitude and latitude; 0 where there is none.
  double UndulationAt(const Eigen::Vector3d& place) const {
    return geoid ? geoid->HeightAt(place.y(), place.x()) : 0.0;
  }

  void SetWkt(const PJ* crs) {
    const char* text = proj_as_wkt(context.get(), crs, PJ_WKT1_GDAL, nullptr);
    if (text == nullptr) {
      throw InputError({where, name + " cannot be written as WKT 1, which LAS needs",
                        "a coordinate reference system with an EPSG code", ""});
    }
    wkt = text;
  }

  void SetEllipsoid(const PJ* crs) {
    const Object found(proj_get_ellipsoid(context.get(), crs));
    double a = 0.0;
    double inverse_flattening = 0.0;
    proj_ellipsoid_get_parameters(context.get(), found.get(), &a, nullptr, nullptr,
                                  &inverse_flattening);
    BACKSIGHT_CHECK(a > 0.0, "a datum has an ellipsoid");
    const double flattening = inverse_flattening == 0.0 ? 0.0 : 1.0 / inverse_flattening;
    ellipsoid = std::make_unique<GeographicLib::Geocentric>(a, flattening);
  }

  [[noreturn]] void RefusePlace(std::string_view frame, const Eigen::Vector3d& place) const {
    throw InputError(
        {where, fmt::format("{} ({:.3f}, {:.3f}, {:.3f})", frame, place.x(), place.y(), place.z()),
         "a place where " + name + " is defined",
         "check the order (easting, northing, height), units and zone of the control"});
  }
};

GeodeticFrame::GeodeticFrame(const std::string& horizontal, const std::string& vertical,
                             const std::string& where)
    : parts_(std::make_unique<Parts>()) {
  PJ_CONTEXT* context = parts_->context.get();
  parts_->where = where;
  const Object plane = FindHorizontal(context, horizontal, where);
  Object crs;
  Object heights;
  if (vertical.empty()) {
    crs.reset(proj_crs_promote_to_3D(context, nullptr, plane.get()));
    parts_->name = proj_get_name(plane.get());
  } else {
    heights = FindVertical(context, vertical, where);
    parts_->name = fmt::format("{} + {}", proj_get_name(plane.get()), proj_get_name(heights.get()));
    crs.reset(proj_create_compound_crs(context, parts_->name.c_str(), plane.get(), heights.get()));
  }
  const Object geodetic(proj_crs_get_geodetic_crs(context, plane.get()));
  const Object target(proj_crs_promote_to_3D(context, nullptr, geodetic.get()));
  BACKSIGHT_CHECK(crs && target, "PROJ combines known systems");
  Object operation = BestOperation(context, crs.get(), target.get(), where);
  const Grids grids = GridsOf(context, operation.get());
  parts_->heights = vertical.empty() ? "ellipsoidal heights" : "by " + grids.used;
  if (!grids.missing.empty()) {
    const std::string code = CodeOf(heights.get());
    parts_->geoid = VerticalGeoid::Open(code);
    if (!parts_->geoid) RefuseMissingGrid(where, parts_->name, grids.missing, code);
    parts_->heights = "by " + parts_->geoid->file_name();
    const Object above(proj_crs_promote_to_3D(context, nullptr, plane.get()));
    operation = BestOperation(context, above.get(), target.get(), where);
  }
  parts_->operation.reset(proj_normalize_for_visualization(context, operation.get()));
  if (!parts_->operation || proj_degree_output(parts_->operation.get(), PJ_FWD) == 0) {
    throw InputError({where, parts_->name + ": its datum counts angles in another unit",
                      "a datum whose geographic coordinates are in degrees", ""});
  }
  parts_->SetWkt(vertical.empty() ? plane.get() : crs.get());
  parts_->SetEllipsoid(plane.get());
  parts_->area = AreaOf(context, plane.get());
}

GeodeticFrame::~GeodeticFrame() = default;
GeodeticFrame::GeodeticFrame(GeodeticFrame&&) noexcept = default;
GeodeticFrame& GeodeticFrame::operator=(GeodeticFrame&&) noexcept = default;

std::optional<InputError::Details> GeodeticFrame::FaultOf(const Eigen::Vector3d& crs) const {
  const std::optional<Area>& area = parts_->area;
  const auto is_within = [&](const std::optional<Eigen::Vector2d>& place) {
    return place && (!area || area->Holds(place->y(), place->x()));
  };
  const std::optional<Eigen::Vector2d> place = parts_->PlaceOf(crs);
  if (is_within(place)) return std::nullopt;
  InputError::Details fault;
  fault.where = parts_->where;
  fault.found = fmt::format("easting {:.3f}, northing {:.3f}", crs.x(), crs.y());
  fault.found +=
      place ? fmt::format(", which is latitude {:.2f}, longitude {:.2f}", place->y(), place->x())
            : ", which is nowhere";
  fault.expected = "a place where " + parts_->name + " is used";
  if (area) {
    fault.expected += fmt::format(": latitude {:.1f} to {:.1f}, longitude {:.1f} to {:.1f}",
                                  area->south, area->north, area->west, area->east);
  }
  const bool swapped = area && is_within(parts_->PlaceOf({crs.y(), crs.x(), crs.z()}));
  fault.remedy = swapped ? "easting and northing swapped? The order is easting, northing, height"
                         : "check order (easting, northing, height), units, zone, and whether the "
                           "easting lacks a prefix of its zone";
  return fault;
}

void GeodeticFrame::SetOrigin(const Eigen::Vector3d& crs) {
  const Eigen::Vector3d place = parts_->Convert(crs, PJ_FWD, "coordinates");
  // Far outside its zone a projection may give some place, but not the way back.
  constexpr double kSame = 1e-3;
  if ((parts_->Convert(place, PJ_INV, "longitude, latitude, height") - crs).norm() > kSame) {
    parts_->RefusePlace("coordinates", crs);
  }
  parts_->origin = {place.y(), place.x(), place.z()};
  parts_->local = std::make_unique<GeographicLib::LocalCartesian>(place.y(), place.x(), place.z(),
                                                                  *parts_->ellipsoid);
  constexpr double kStep = 50.0;
  const Eigen::Vector3d north = EnuFromCrs(crs + kStep * Eigen::Vector3d::UnitY()) -
                                EnuFromCrs(crs - kStep * Eigen::Vector3d::UnitY());
  parts_->convergence_deg = std::atan2(north.x(), north.y()) * 180.0 / std::numbers::pi;
  const double to_ellipsoid = 1.0 + place.z() / parts_->ellipsoid->EquatorialRadius();
  parts_->point_scale = 2.0 * kStep * to_ellipsoid / north.norm();
}

Eigen::Vector3d GeodeticFrame::EnuFromCrs(const Eigen::Vector3d& crs) const {
  const Eigen::Vector3d place = parts_->Convert(crs, PJ_FWD, "coordinates");
  Eigen::Vector3d enu;
  parts_->local->Forward(place.y(), place.x(), place.z(), enu.x(), enu.y(), enu.z());
  return enu;
}

Eigen::Vector3d GeodeticFrame::CrsFromEnu(const Eigen::Vector3d& enu) const {
  double latitude = 0.0;
  double longitude = 0.0;
  double height = 0.0;
  parts_->local->Reverse(enu.x(), enu.y(), enu.z(), latitude, longitude, height);
  return parts_->Convert({longitude, latitude, height}, PJ_INV, "longitude, latitude, height");
}

Eigen::Matrix3d GeodeticFrame::AxesAt(const Eigen::Vector3d& crs) const {
  constexpr double kStep = 50.0;
  const auto direction = [&](int axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    return Eigen::Vector3d(EnuFromCrs(crs + step) - EnuFromCrs(crs - step));
  };
  Eigen::Matrix3d axes;
  axes.col(2) = direction(2).normalized();
  const Eigen::Vector3d east = direction(0);
  axes.col(0) = (east - east.dot(axes.col(2)) * axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

double GeodeticFrame::convergence_deg() const { return parts_->convergence_deg; }
double GeodeticFrame::point_scale() const { return parts_->point_scale; }
const std::string& GeodeticFrame::name() const { return parts_->name; }
const std::string& GeodeticFrame::wkt() const { return parts_->wkt; }
const std::string& GeodeticFrame::heights() const { return parts_->heights; }
const Eigen::Vector3d& GeodeticFrame::origin() const { return parts_->origin; }

}  // namespace backsight
