#include "io/report_style.h"

namespace backsight {

// Colours after Okabe and Ito, distinct under the common colour-vision deficiencies; line widths
// and signs repeat what colours say.
std::string_view ReportStyle() {
  return R"(
:root { --good: #00664d; --bad: #a33c00; --line: #d5d9de; --soft: #5a6470; }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, "DejaVu Sans", sans-serif;
  color: #1a1f26; background: #fff; max-width: 1100px; margin: 0 auto; padding: 28px 24px 60px;
  overflow-wrap: anywhere; }
h1 { font-size: 27px; line-height: 1.2; margin: 0 0 2px; }
h2 { font-size: 19px; margin: 36px 0 8px; border-bottom: 2px solid var(--line); }
h3 { font-size: 16px; margin: 20px 0 6px; }
p { margin: 6px 0; }
ul { margin: 6px 0; padding-left: 22px; }
.soft { color: var(--soft); font-size: 13px; line-height: 1.4; }
.frame { margin: 8px 0 0; }
.verdict { border-left: 7px solid var(--bad); background: #fbf1eb; font-size: 18px;
  padding: 12px 16px; margin: 18px 0; }
.verdict.pass { border-color: var(--good); background: #ebf6f2; }
.verdict .good, .verdict .bad { white-space: normal; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(160px, 1fr)); gap: 10px;
  margin: 16px 0; }
.card { border: 1px solid var(--line); border-radius: 6px; padding: 9px 13px; }
.card b { display: block; font-size: 23px; line-height: 1.3; font-variant-numeric: tabular-nums; }
.card span { color: var(--soft); font-size: 13px; display: block; line-height: 1.35; }
table { border-collapse: collapse; font-size: 13px; min-width: 45%; max-width: 100%;
  margin: 8px 0; }
th { text-align: left; vertical-align: bottom; border-bottom: 1.5px solid #1a1f26;
  line-height: 1.25; padding: 4px 12px 4px 0; font-weight: 600; overflow-wrap: normal; }
td { border-bottom: 1px solid var(--line); padding: 4px 12px 4px 0; vertical-align: top; }
th:last-child, td:last-child { padding-right: 0; }
.n { text-align: right; font-variant-numeric: tabular-nums; }
td.n, .pair { white-space: nowrap; }
.off td { background: #f6f6f4; }
.good { color: var(--good); white-space: nowrap; }
.bad { color: var(--bad); font-weight: 600; white-space: nowrap; }
code { font-size: 12px; }
svg.plan, svg.chart { width: 100%; height: auto; border: 1px solid var(--line); background: #fff;
  display: block; }
svg.picture { max-width: 100%; height: auto; display: block; }
.link { stroke-linecap: round; }
.rejected { stroke: #8a9099; stroke-width: 1.1; stroke-dasharray: 5 6; }
.r0 { stroke: #0072b2; stroke-width: 1.8; }
.r1 { stroke: #009e73; stroke-width: 2.8; }
.r2 { stroke: #e69f00; stroke-width: 4; }
.r3 { stroke: #d55e00; stroke-width: 5.5; }
.noloop { fill: #fff; stroke: #a33c00; stroke-width: 2; }
.weak { fill: none; stroke: #7b2d8b; stroke-width: 2.4; }
.sigma { fill: #f0e442; fill-opacity: .35; stroke: #1a1f26; stroke-width: 1; }
.station { fill: #1a1f26; stroke: #fff; stroke-width: 1.5; }
.control { fill: #fff; stroke: #1a1f26; stroke-width: 1.8; }
.check { fill: #56b4e9; stroke: #1a1f26; stroke-width: 1.5; }
.excluded { fill: #fff; stroke: #a33c00; stroke-width: 1.8; stroke-dasharray: 3 2; }
.vector { stroke: #d55e00; stroke-width: 2.4; fill: none; }
.rise { stroke: #0072b2; stroke-width: 4; }
.faint { fill: #a8aeb6; }
.label { font: 600 14px system-ui, "DejaVu Sans", sans-serif; paint-order: stroke; stroke: #fff;
  stroke-width: 3.5; }
.note { font: 13px system-ui, "DejaVu Sans", sans-serif; fill: #414a55; }
.axis { fill: none; stroke: #414a55; stroke-width: 1.5; }
.tick { stroke: #414a55; stroke-width: 1; }
.bar { fill: #56b4e9; stroke: #fff; stroke-width: 1; }
.quantile { stroke: #d55e00; stroke-width: 2; }
.cut { stroke: #d62728; stroke-width: 1.6; stroke-dasharray: 9 4 2 4; }
.cutname { font: 700 17px system-ui, "DejaVu Sans", sans-serif; fill: #d62728; paint-order: stroke;
  stroke: #fff; stroke-width: 4; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 20px; font-size: 13px; align-items: center;
  margin: 6px 0; }
.legend svg { vertical-align: middle; margin-right: 5px; }
.key { display: inline-block; width: 10px; height: 10px; margin-right: 6px; border-radius: 2px; }
.key.r0 { background: #0072b2; } .key.r1 { background: #009e73; }
.key.r2 { background: #e69f00; } .key.r3 { background: #d55e00; }
figure { margin: 14px 0; break-inside: avoid; }
figure h3 { margin-top: 0; }
figcaption { font-size: 13px; color: var(--soft); line-height: 1.4; }
.legend { break-inside: avoid; }
.sign { break-before: avoid; margin-top: 40px; display: grid; grid-template-columns: 1fr 1fr; gap: 40px;
  break-inside: avoid; }
.sign div { border-top: 1px solid #1a1f26; padding-top: 4px; font-size: 13px; margin-top: 44px; }
@media print {
  body { font-size: 9.5pt; line-height: 1.4; max-width: none; padding: 0; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h1 { font-size: 18pt; }
  h2 { font-size: 13pt; margin-top: 18pt; }
  h3 { font-size: 10.5pt; }
  h2, h3 { break-after: avoid; }
  p, li { orphans: 3; widows: 3; }
  tr, .card, .verdict, svg, figure { break-inside: avoid; }
  .verdict { font-size: 12pt; }
  .cards { grid-template-columns: repeat(3, 1fr); gap: 6px; }
  .card b { font-size: 14pt; }
  .card span, .soft, figcaption, .legend { font-size: 8pt; }
  svg.plan { max-height: 190mm; }
  svg.picture { max-height: 185mm; }
  svg.section, svg.detail { max-height: 100mm; }
  thead { display: table-header-group; }
}
/* A4 paper less its margins is 688 px wide. */
@media print, (max-width: 900px) {
  table { font-size: 7.5pt; min-width: 0; }
  th, td { padding: 2pt 5pt 2pt 0; }
  th { overflow-wrap: break-word; }
  code { font-size: 7pt; }
}
@media (max-width: 900px) { body { padding-left: 0; padding-right: 0; } }
@page { size: A4 portrait; margin: 16mm 14mm; }
)";
}

}  // namespace backsight
