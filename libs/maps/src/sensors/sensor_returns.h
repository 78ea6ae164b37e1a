// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sensor_returns.h
/// One reader per observation class; see observation_rays.h.

#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <superray/maps/observation_rays.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace superray {

/// Collects one of every `decimation` measurements.
class ReturnCollector {
 public:
    /// \param sensorMaximum [m] maximum range of the sensor, <= 0 or Inf: unknown
    ReturnCollector(SensorReturns& out, const ReturnOptions& options, double sensorMaximum)
        : out_(out), decimation_(options.decimation) {
        const double range = options.noReturnRange > 0 ? options.noReturnRange : sensorMaximum;
        if (options.noReturnRays && range > 0 && std::isfinite(range))
            noReturnRange_ = static_cast<float>(range);
        timed_ = options.times == ReturnTimes::read;
        if (sensorMaximum > 0) sensorMaximum_ = static_cast<float>(sensorMaximum);
    }

    /// Time of the measurements that follow [s], after the observation's.
    void measuredAt(double seconds) { seconds_ = static_cast<float>(seconds); }

    /// False if this measurement is to be left out. To be asked once for each.
    bool next() {
        if (decimation_ == 1) return true;
        const bool taken = index_ == 0;
        index_ = index_ + 1 == decimation_ ? 0 : index_ + 1;
        return taken;
    }

    /// A return, or none if it is farther than the sensor can see.
    void hit(const Eigen::Vector3f& point, float range) {
        if (range > sensorMaximum_) return noReturn(point);
        out_.hits.push_back(point);
        if (timed_) out_.hitTimes.push_back(seconds_);
    }

    /// \param direction of any length > 0, sensor frame
    void noReturn(const Eigen::Vector3f& direction) {
        ++out_.noReturnCount;
        if (noReturnRange_ <= 0) return;
        out_.noReturns.push_back(direction.normalized() * noReturnRange_);
        if (timed_) out_.noReturnTimes.push_back(seconds_);
    }
    /// A measurement that tells nothing, e.g. one out of the sensor's limits.
    void invalid() { ++out_.noReturnCount; }

 private:
    SensorReturns& out_;
    unsigned decimation_;
    unsigned index_ = 0;
    float noReturnRange_ = 0;
    float sensorMaximum_ = std::numeric_limits<float>::infinity();
    bool timed_ = false;
    float seconds_ = 0;
};

/// Points of any containers of x, y, z; (0, 0, 0) means no return.
/// \param secondsOf when point i was measured, see ReturnCollector::measuredAt()
/// \throws std::invalid_argument if x, y and z differ in size: a recording may claim that
template <class Floats, class SecondsOf>
void collectPoints(const Floats& x, const Floats& y, const Floats& z, ReturnCollector& to,
                   SecondsOf secondsOf) {
    if (y.size() != x.size() || z.size() != x.size())
        throw std::invalid_argument("points with " + std::to_string(x.size()) + " x, " +
                                    std::to_string(y.size()) + " y and " +
                                    std::to_string(z.size()) + " z: must have as many of each");
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (!to.next()) continue;
        to.measuredAt(secondsOf(i));
        if (x[i] == 0 && y[i] == 0 && z[i] == 0) {
            to.invalid();
        } else {
            const Eigen::Vector3f point(x[i], y[i], z[i]);
            to.hit(point, point.norm());
        }
    }
}

template <class Floats>
void collectPoints(const Floats& x, const Floats& y, const Floats& z, ReturnCollector& to) {
    collectPoints(x, y, z, to, [](std::size_t) { return 0.0; });
}

/// True if the range image alone tells where the points are: several rows need
/// vertical angles, which the class does not have.
inline bool isOneRow(const mrpt::obs::CObservationRotatingScan& scan) {
    return scan.rowCount == 1 && scan.rangeImage.rows() == 1 && scan.rangeImage.cols() >= 1;
}

std::optional<SensorReturns> read(const mrpt::obs::CObservation3DRangeScan&,
                                  const ReturnOptions&);
std::optional<SensorReturns> read(const mrpt::obs::CObservationVelodyneScan&,
                                  const ReturnOptions&);
std::optional<SensorReturns> read(const mrpt::obs::CObservationPointCloud&,
                                  const ReturnOptions&);
std::optional<SensorReturns> read(const mrpt::obs::CObservation2DRangeScan&,
                                  const ReturnOptions&);
std::optional<SensorReturns> read(const mrpt::obs::CObservationRotatingScan&,
                                  const ReturnOptions&);

}  // namespace superray
