// Finds the largest spot of a colour in the picture of a camera with OpenCV, and turns the robot to it.
#pragma once

#include <jde.hpp>

#include <algorithm>
#include <opencv2/imgproc.hpp>

struct TrackerPorts : jde::Ports {
    jde::Import<jde::Image> image{*this, "image", "The picture. A new one triggers an iteration.", jde::trigger};
    jde::Modulation<double> hue_from{*this, "hue_from", "Where the hues begin.", 20.0, jde::unit("deg"), jde::min(0.0), jde::max(360.0)};
    jde::Modulation<double> hue_to{*this, "hue_to", "Where the hues end.", 45.0, jde::unit("deg"), jde::min(0.0), jde::max(360.0)};
    jde::Modulation<double> view{*this, "view", "Width of the camera's view.", 47.5, jde::unit("deg"), jde::min(1.0), jde::max(179.0)};
    jde::Modulation<std::uint32_t> least{*this, "least", "Fewer pixels are no spot.", 30, jde::unit("px")};
    jde::Export<double> bearing{*this, "bearing", "Direction of the spot, to the left. It has no value while none is seen.", jde::unit("rad")};
};

class Tracker : public jde::Perceptive<TrackerPorts> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"tracker", "Finds the largest spot of a colour in a picture.", 100ms};
    }

    void iterate(jde::Context &cx) override
    {
        const auto picture = image.get(cx);
        if (!picture) {
            return;
        }
        const auto data = jde::elements(picture->data);
        if (jde::text(picture->encoding) != "rgb8" || std::size_t{picture->step} * picture->height > data.size()) {
            throw jde::Failure("the picture is not complete, or no rgb8");
        }
        // OpenCV reads the picture in place; it does not write.
        const cv::Mat rgb(static_cast<int>(picture->height), static_cast<int>(picture->width), CV_8UC3, const_cast<std::uint8_t *>(data.data()),
                          picture->step);
        cv::cvtColor(rgb, hsv_, cv::COLOR_RGB2HSV);
        // OpenCV halves hues, so that they fit a byte.
        cv::inRange(hsv_, cv::Scalar(hue_from.get(cx) / 2.0, 120, 60), cv::Scalar(hue_to.get(cx) / 2.0, 255, 255), mask_);
        const int spots = cv::connectedComponentsWithStats(mask_, labels_, stats_, centers_);
        int largest = 0;
        for (int spot = 1; spot < spots; spot++) {
            if (largest == 0 || area(spot) > area(largest)) {
                largest = spot;
            }
        }
        if (largest == 0 || area(largest) < static_cast<int>(least.get(cx))) {
            bearing.retract(cx);
            return;
        }
        const double half = static_cast<double>(picture->width) / 2.0;
        const double offset = (half - centers_.at<double>(largest, 0)) / half;
        bearing.write_at(cx, std::atan(offset * std::tan(view.get(cx) * jde::pi / 360.0)), picture.time());
    }

private:
    int area(int spot) const { return stats_.at<int>(spot, cv::CC_STAT_AREA); }
    // The buffers are used again.
    cv::Mat hsv_, mask_, labels_, stats_, centers_;
};

struct ChasePorts : jde::Ports {
    jde::Import<double> bearing{*this, "bearing", "Direction to turn to.", jde::trigger, jde::unit("rad")};
    jde::Actuator<jde::Twist> base{*this, "base", "Speeds of the base."};
};

class Chase : public jde::Motor<ChasePorts> {
public:
    static constexpr jde::About about()
    {
        using namespace std::chrono_literals;
        return {"chase", "Turns to what the tracker sees.", 100ms};
    }

    jde::Precondition check(jde::Context &cx) override { return bool(bearing.get(cx)); }
    void iterate(jde::Context &cx) override { base.command(cx, jde::planar(0.0, std::clamp(*bearing.require(cx), -0.8, 0.8))); }
};
