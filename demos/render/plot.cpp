// SPDX-License-Identifier: MIT
#include "demos/render/plot.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "granular/base/require.h"

namespace granular_demo {
namespace {

constexpr double kTextSize = 11.0, kTitleSize = 12.5, kFigureTitleSize = 15.0;  // points
constexpr double kScriptSize = 0.72;  // raised and lowered text, of its line
const Color kInk(0.13f, 0.14f, 0.16f), kGridInk(0.89f, 0.90f, 0.91f), kMinorInk(0.95f, 0.95f, 0.96f);

/// Okabe & Ito 2008, ordered for contrast on white.
Color seriesColor(const Panel& panel, std::size_t index) {
  static const std::array<Color, 8> colors = {Color(0.000f, 0.447f, 0.698f), Color(0.835f, 0.369f, 0.000f),
                                              Color(0.000f, 0.620f, 0.451f), Color(0.800f, 0.475f, 0.655f),
                                              Color(0.902f, 0.624f, 0.000f), Color(0.337f, 0.706f, 0.914f),
                                              Color(0.25f, 0.25f, 0.25f),    Color(0.60f, 0.42f, 0.20f)};
  if (panel.series[index].color) return *panel.series[index].color;
  return colors[index % colors.size()];
}

struct Rectangle {
  double left, top, width, height;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

/// cairo with our few habits: colours, text with scripts.
class Canvas {
 public:
  Canvas(double width, double height, double scale)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(std::ceil(width * scale)),
                                            static_cast<int>(std::ceil(height * scale)))),
        context_(cairo_create(surface_.get())) {
    cairo_scale(context(), scale, scale);
    cairo_set_source_rgb(context(), 1, 1, 1);
    cairo_paint(context());
    cairo_set_line_join(context(), CAIRO_LINE_JOIN_ROUND);
  }

  cairo_t* context() const { return context_.get(); }

  void setColor(const Color& color, double opacity = 1.0) const {
    cairo_set_source_rgba(context(), color.x(), color.y(), color.z(), opacity);
  }

  void strokeLine(double x0, double y0, double x1, double y1, const Color& color, double width) const {
    setColor(color);
    cairo_set_line_width(context(), width);
    cairo_move_to(context(), x0, y0);
    cairo_line_to(context(), x1, y1);
    cairo_stroke(context());
  }

  double textWidth(const std::string& text, double size) const { return layText(text, size, false); }

  /// Baseline at y; x is the text's left (alignment 0), middle (0.5) or right end (1).
  void drawText(const std::string& text, double x, double y, double alignment, double size,
                bool bold = false) const {
    setColor(kInk);
    selectFont(bold);
    cairo_save(context());
    cairo_translate(context(), x - alignment * layText(text, size, false), y);
    layText(text, size, true);
    cairo_restore(context());
    selectFont(false);
  }

  void drawTextUpwards(const std::string& text, double x, double y, double size) const {
    cairo_save(context());
    cairo_translate(context(), x, y);
    cairo_rotate(context(), -0.5 * std::numbers::pi);
    drawText(text, 0.0, 0.0, 0.5, size);
    cairo_restore(context());
  }

  void write(const std::filesystem::path& path) const {
    const cairo_status_t status = cairo_surface_write_to_png(surface_.get(), path.c_str());
    if (status != CAIRO_STATUS_SUCCESS)
      throw std::runtime_error("Cannot write figure '" + path.string() +
                               "': " + cairo_status_to_string(status));
  }

 private:
  void selectFont(bool bold) const {
    cairo_select_font_face(context(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  }

  /// Width of a text with its scripts; shows it from (0, 0) when asked.
  double layText(const std::string& text, double size, bool show) const {
    double x = 0.0;
    for (std::size_t at = 0; at < text.size();) {
      const bool isScript =
          (text[at] == '^' || text[at] == '_') && at + 1 < text.size() && text[at + 1] == '{';
      const std::size_t start = isScript ? at + 2 : at;
      std::size_t end =
          isScript ? text.find('}', start) : std::min(text.find("^{", start), text.find("_{", start));
      end = std::min(end, text.size());
      const std::string piece = text.substr(start, end - start);
      const double rise = !isScript ? 0.0 : text[at] == '^' ? -0.38 * size : 0.22 * size;
      cairo_set_font_size(context(), isScript ? kScriptSize * size : size);
      cairo_text_extents_t extents;
      cairo_text_extents(context(), piece.c_str(), &extents);
      if (show) {
        cairo_move_to(context(), x, rise);
        cairo_show_text(context(), piece.c_str());
      }
      x += extents.x_advance;
      at = isScript ? end + 1 : end;
    }
    return x;
  }

  struct Destroy {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
  };
  std::unique_ptr<cairo_surface_t, Destroy> surface_;
  std::unique_ptr<cairo_t, Destroy> context_;
};

AxisRange rangeFor(const Axis& axis, const Panel& panel, std::vector<double> Series::*values,
                   const char* name) {
  const std::string field = "Axis " + std::string(name) + " of panel '" + panel.title + "'";
  AxisRange range{axis.scale};
  if (axis.low && axis.high) {
    range = {axis.scale, *axis.low, *axis.high};
  } else {
    std::vector<double> all;
    for (const Series& series : panel.series)
      all.insert(all.end(), (series.*values).begin(), (series.*values).end());
    range = rangeAround(axis.scale, all, field);
    range.low = axis.low.value_or(range.low);
    range.high = axis.high.value_or(range.high);
  }
  const bool fine = range.canShow(range.low) && range.canShow(range.high) && range.low < range.high;
  granular::require(fine, field, std::to_string(range.low) + " to " + std::to_string(range.high), "",
                    "finite, rising, and > 0 when logarithmic");
  return range;
}

/// One panel on its way to paper.
class PanelPainter {
 public:
  PanelPainter(const Canvas& canvas, const Panel& panel, const Rectangle& outside)
      : canvas_(canvas),
        panel_(panel),
        x_(rangeFor(panel.x, panel, &Series::x, "x")),
        y_(rangeFor(panel.y, panel, &Series::y, "y")),
        xTicks_(ticksOf(x_, static_cast<int>(outside.width / 75.0) + 1)),
        yTicks_(ticksOf(y_, static_cast<int>(outside.height / 50.0) + 1)) {
    double labelWidth = 0.0;
    for (const Tick& tick : yTicks_)
      labelWidth = std::max(labelWidth, canvas.textWidth(tick.label, kTextSize));
    const double left = 18.0 + labelWidth + (panel.y.label.empty() ? 0.0 : 20.0);
    const double top = panel.title.empty() ? 14.0 : 34.0;
    const double bottom = panel.x.label.empty() ? 28.0 : 46.0;
    frame_ = {outside.left + left, outside.top + top, outside.width - left - 18.0,
              outside.height - top - bottom};
    outside_ = outside;
  }

  void paint() const {
    paintGrid();
    paintSeries();
    paintFrame();
    paintLegend();
  }

 private:
  double toPaperX(double x) const { return frame_.left + x_.fraction(x) * frame_.width; }
  double toPaperY(double y) const { return frame_.bottom() - y_.fraction(y) * frame_.height; }

  void paintGrid() const {
    for (const bool major : {false, true}) {
      const Color& ink = major ? kGridInk : kMinorInk;
      for (const Tick& tick : xTicks_)
        if (tick.label.empty() != major)
          canvas_.strokeLine(toPaperX(tick.value), frame_.top, toPaperX(tick.value), frame_.bottom(), ink,
                             0.8);
      for (const Tick& tick : yTicks_)
        if (tick.label.empty() != major)
          canvas_.strokeLine(frame_.left, toPaperY(tick.value), frame_.right(), toPaperY(tick.value), ink,
                             0.8);
    }
  }

  void paintFrame() const {
    canvas_.setColor(kInk);
    cairo_set_line_width(canvas_.context(), 0.9);
    cairo_rectangle(canvas_.context(), frame_.left, frame_.top, frame_.width, frame_.height);
    cairo_stroke(canvas_.context());
    for (const Tick& tick : xTicks_) {
      const double x = toPaperX(tick.value), length = tick.label.empty() ? 2.5 : 4.5;
      canvas_.strokeLine(x, frame_.bottom(), x, frame_.bottom() - length, kInk, 0.8);
      canvas_.drawText(tick.label, x, frame_.bottom() + 16.0, 0.5, kTextSize);
    }
    for (const Tick& tick : yTicks_) {
      const double y = toPaperY(tick.value), length = tick.label.empty() ? 2.5 : 4.5;
      canvas_.strokeLine(frame_.left, y, frame_.left + length, y, kInk, 0.8);
      canvas_.drawText(tick.label, frame_.left - 6.0, y + 0.36 * kTextSize, 1.0, kTextSize);
    }
    const double middle = frame_.left + 0.5 * frame_.width;
    canvas_.drawText(panel_.title, middle, frame_.top - 11.0, 0.5, kTitleSize, true);
    canvas_.drawText(panel_.x.label, middle, frame_.bottom() + 36.0, 0.5, kTextSize);
    canvas_.drawTextUpwards(panel_.y.label, outside_.left + 16.0, frame_.top + 0.5 * frame_.height,
                            kTextSize);
  }

  void paintSeries() const {
    cairo_t* context = canvas_.context();
    cairo_save(context);
    cairo_rectangle(context, frame_.left, frame_.top, frame_.width, frame_.height);
    cairo_clip(context);
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      canvas_.setColor(seriesColor(panel_, i));
      bool isDrawing = false;
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        const bool visible = x_.canShow(series.x[k]) && y_.canShow(series.y[k]);
        if (visible && isDrawing) cairo_line_to(context, toPaperX(series.x[k]), toPaperY(series.y[k]));
        if (visible && !isDrawing) cairo_move_to(context, toPaperX(series.x[k]), toPaperY(series.y[k]));
        isDrawing = visible;
      }
      strokeSeries(series);
    }
    cairo_restore(context);
    // Markers after all lines, and whole even where they touch the frame.
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      for (std::size_t k = 0; k < series.x.size(); ++k)
        if (isInside(series.x[k], series.y[k]))
          paintMarker(series.marker, toPaperX(series.x[k]), toPaperY(series.y[k]), seriesColor(panel_, i));
    }
  }

  bool isInside(double x, double y) const {
    if (!x_.canShow(x) || !y_.canShow(y)) return false;
    const double u = x_.fraction(x), v = y_.fraction(y);
    return u >= -1e-9 && u <= 1.0 + 1e-9 && v >= -1e-9 && v <= 1.0 + 1e-9;
  }

  /// Strokes the current path, or drops it when the series has no line.
  void strokeSeries(const Series& series) const {
    cairo_t* context = canvas_.context();
    if (series.line == Line::none) return cairo_new_path(context);
    const std::array<double, 2> dashes = {7.0, 4.0}, dots = {1.5, 3.0};
    if (series.line == Line::dashed) cairo_set_dash(context, dashes.data(), 2, 0.0);
    if (series.line == Line::dotted) cairo_set_dash(context, dots.data(), 2, 0.0);
    cairo_set_line_width(context, series.width);
    cairo_stroke(context);
    cairo_set_dash(context, nullptr, 0, 0.0);
  }

  void paintMarker(Marker marker, double x, double y, const Color& color) const {
    if (marker == Marker::none) return;
    cairo_t* context = canvas_.context();
    const double r = 3.6;
    cairo_new_sub_path(context);
    switch (marker) {
      case Marker::none:
        break;
      case Marker::circle:
        cairo_arc(context, x, y, r, 0.0, 2.0 * std::numbers::pi);
        break;
      case Marker::square:
        cairo_rectangle(context, x - 0.88 * r, y - 0.88 * r, 1.76 * r, 1.76 * r);
        break;
      case Marker::triangle:
        polygon({{x, y - 1.2 * r}, {x + 1.1 * r, y + 0.8 * r}, {x - 1.1 * r, y + 0.8 * r}});
        break;
      case Marker::diamond:
        polygon({{x, y - 1.25 * r}, {x + 1.25 * r, y}, {x, y + 1.25 * r}, {x - 1.25 * r, y}});
        break;
      case Marker::cross:
        canvas_.strokeLine(x - r, y - r, x + r, y + r, color, 1.6);
        canvas_.strokeLine(x - r, y + r, x + r, y - r, color, 1.6);
        return;
    }
    canvas_.setColor(color);
    cairo_fill_preserve(context);
    canvas_.setColor(Color::Ones());  // a white rim keeps points apart from lines and from each other
    cairo_set_line_width(context, 0.8);
    cairo_stroke(context);
  }

  void polygon(const std::vector<std::array<double, 2>>& corners) const {
    for (const auto& [x, y] : corners) cairo_line_to(canvas_.context(), x, y);
    cairo_close_path(canvas_.context());
  }

  void paintLegend() const {
    constexpr double kLineHeight = 17.0, kSample = 26.0, kPadding = 8.0;
    double width = 0.0;
    int entries = 0;
    for (const Series& series : panel_.series) {
      if (series.name.empty()) continue;
      ++entries;
      width = std::max(width, kSample + 8.0 + canvas_.textWidth(series.name, kTextSize) + 2.0 * kPadding);
    }
    if (entries == 0) return;
    const Rectangle box = emptiestCorner(width, entries * kLineHeight + kPadding);
    cairo_t* context = canvas_.context();
    cairo_rectangle(context, box.left, box.top, box.width, box.height);
    canvas_.setColor(Color::Ones(), 0.88);
    cairo_fill_preserve(context);
    canvas_.setColor(kGridInk);
    cairo_set_line_width(context, 0.8);
    cairo_stroke(context);
    double y = box.top + 0.5 * (kPadding + kLineHeight);
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (series.name.empty()) continue;
      const double x = box.left + kPadding;
      canvas_.setColor(seriesColor(panel_, i));
      cairo_move_to(context, x, y);
      cairo_line_to(context, x + kSample, y);
      strokeSeries(series);
      paintMarker(series.marker, x + 0.5 * kSample, y, seriesColor(panel_, i));
      canvas_.drawText(series.name, x + kSample + 8.0, y + 0.36 * kTextSize, 0.0, kTextSize);
      y += kLineHeight;
    }
  }

  /// The corner of the frame where a legend of this size hides least.
  Rectangle emptiestCorner(double width, double height) const {
    constexpr double kGap = 9.0;
    const double right = frame_.right() - kGap - width, bottom = frame_.bottom() - kGap - height;
    const double left = frame_.left + kGap, top = frame_.top + kGap;
    Rectangle best{right, top, width, height};
    double least = hidden(best);
    for (const Rectangle& corner :
         {Rectangle{left, top, width, height}, Rectangle{left, bottom, width, height},
          Rectangle{right, bottom, width, height}}) {
      const double covers = hidden(corner);
      if (covers < least) {
        least = covers;
        best = corner;
      }
    }
    return best;
  }

  /// How much of the data lies behind a rectangle: samples along every line.
  double hidden(const Rectangle& box) const {
    constexpr int kSamplesPerSegment = 16;
    double count = 0.0;
    for (const Series& series : panel_.series) {
      const double share = 1.0 / static_cast<double>(std::max<std::size_t>(series.x.size(), 1));
      for (std::size_t k = 0; k + 1 < series.x.size(); ++k) {
        if (!isInside(series.x[k], series.y[k]) || !isInside(series.x[k + 1], series.y[k + 1])) continue;
        for (int s = 0; s <= kSamplesPerSegment; ++s) {
          const double t = static_cast<double>(s) / kSamplesPerSegment;
          const double x = std::lerp(toPaperX(series.x[k]), toPaperX(series.x[k + 1]), t);
          const double y = std::lerp(toPaperY(series.y[k]), toPaperY(series.y[k + 1]), t);
          if (x > box.left - 6.0 && x < box.right() + 6.0 && y > box.top - 6.0 && y < box.bottom() + 6.0)
            count += share;
        }
      }
    }
    return count;
  }

  const Canvas& canvas_;
  const Panel& panel_;
  AxisRange x_, y_;
  std::vector<Tick> xTicks_, yTicks_;
  Rectangle frame_{}, outside_{};
};

void checkFigure(const Figure& figure) {
  granular::require(!figure.panels.empty(), "Figure.panels.size()", 0, "", "> 0");
  granular::require(figure.columns > 0, "Figure.columns", figure.columns, "", "> 0");
  granular::require(figure.pixelsPerPoint > 0.0 && figure.pixelsPerPoint <= 10.0, "Figure.pixelsPerPoint",
                    figure.pixelsPerPoint, "", "in (0, 10]");
  for (const double side : {figure.panelWidth, figure.panelHeight})
    granular::require(side >= 150.0 && side <= 3000.0, "Figure.panelWidth or panelHeight", side, "points",
                      "in [150, 3000]");
  for (const Panel& panel : figure.panels)
    for (const Series& series : panel.series)
      granular::require(series.x.size() == series.y.size(), "Series '" + series.name + "': number of x",
                        series.x.size(), "", "the number of y, " + std::to_string(series.y.size()));
}

}  // namespace

void writeFigure(const Figure& figure, const std::filesystem::path& path) {
  checkFigure(figure);
  const int count = static_cast<int>(figure.panels.size());
  const int columns = std::min(figure.columns, count);
  const int rows = (count + columns - 1) / columns;
  const double titleHeight = figure.title.empty() ? 0.0 : 30.0;
  const double width = columns * figure.panelWidth;
  const Canvas canvas(width, titleHeight + rows * figure.panelHeight, figure.pixelsPerPoint);
  canvas.drawText(figure.title, 0.5 * width, 23.0, 0.5, kFigureTitleSize, true);
  for (int i = 0; i < count; ++i) {
    const Rectangle place{i % columns * figure.panelWidth, titleHeight + i / columns * figure.panelHeight,
                          figure.panelWidth, figure.panelHeight};
    PanelPainter(canvas, figure.panels[static_cast<std::size_t>(i)], place).paint();
  }
  canvas.write(path);
}

}  // namespace granular_demo
