#include "trunnion/report/html.hpp"

#include "report/assets.hpp"
#include "report/scene_data.hpp"
#include "report/summary.hpp"
#include "report/text.hpp"

namespace trunnion {

namespace {

// three.js and its OrbitControls are distributed under these terms; the minified script does not carry them itself.
constexpr std::string_view kThreeLicence = R"(/*!
three.js r111 and its OrbitControls. The MIT License.
Copyright (c) 2010-2019 three.js authors

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation
files (the "Software"), to deal in the Software without restriction, including without limitation the rights to use, copy,
modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the
Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE,
ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
*/
)";

// The policy allows what stands in the page and nothing else: should a text ever escape, it could not load or send.
constexpr std::string_view kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
)";

constexpr std::string_view kErrorCollector = R"(<script>
window.reportErrors = [];
window.addEventListener('error', function (event) { window.reportErrors.push(String(event.message)); });
</script>
)";

constexpr std::string_view kView = R"html(<main>
<div class="bar" id="scene-bar">
  <span class="group" role="group" aria-label="Views">
    <button type="button" data-view="fit" title="Show everything (F)">Fit</button>
    <button type="button" data-view="iso">Iso</button>
    <button type="button" data-view="top">Top</button>
    <button type="button" data-view="front">Front</button>
    <button type="button" data-view="right">Right</button>
  </span>
  <span class="group" id="toggles" role="group" aria-label="Show"></span>
  <label class="group slider">Part <input type="range" id="opacity" min="0" max="100" value="100" aria-label="Opacity of the part"></label>
</div>
<div id="scene"><canvas id="scene-canvas" tabindex="0" aria-label="Part, tool path and tool"></canvas><p id="scene-message" hidden></p><div id="legend"></div></div>
<div class="bar" id="player">
  <button type="button" id="play" class="wide">Play</button>
  <span class="group">
    <button type="button" id="previous" title="Previous pose (left arrow)">◂</button>
    <button type="button" id="next" title="Next pose (right arrow)">▸</button>
  </span>
  <input type="range" id="scrub" min="0" max="1" step="any" value="0" aria-label="Position along the path">
  <output id="clock"></output>
  <label>Speed <select id="speed"></select></label>
  <button type="button" id="problem">Next problem</button>
</div>
<dl id="readout"></dl>
<canvas id="plots" aria-label="Axis positions and feed along the path"></canvas>
</main>
)html";

}  // namespace

std::string report_html(const ReportInput& input) {
    TRUNNION_REQUIRE(input.plan != nullptr);
    const std::string scene = report::scene_html(input);
    const std::string_view scripts[] = {report::three_js(), report::orbit_controls_js(), report::viewer_js()};
    std::string page;
    page.reserve(scene.size() + scripts[0].size() + scripts[1].size() + scripts[2].size() + (std::size_t{1} << 16));
    page += kHead;
    page += "<title>" + report::html_text(input.title.empty() ? "Tool path report" : input.title) + "</title>\n<style>\n";
    page += report::viewer_css();
    page += "</style>\n</head>\n<body>\n";
    page += kErrorCollector;
    page += "<aside>\n" + report::summary_html(input) + "</aside>\n";
    page += kView;
    page += scene;
    page += "<script>\n";
    page += kThreeLicence;
    page += scripts[0];
    page += scripts[1];
    page += "</script>\n<script>\n(function () {\n'use strict';\n";
    page += scripts[2];
    page += "start();\n})();\n</script>\n</body>\n</html>\n";
    return page;
}

}  // namespace trunnion
