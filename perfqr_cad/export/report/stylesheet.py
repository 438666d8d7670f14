"""The report's style sheet: system fonts, two columns on a screen, one on a phone."""

STYLE = """
:root { color-scheme: light; --ink: #22262b; --soft: #6b737c; --rule: #dfe3e7; --accent: #2b6a94; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1080px; padding: 32px 28px 56px; color: var(--ink); background: #fff;
  font: 15px/1.45 system-ui, -apple-system, "Segoe UI", "Liberation Sans", sans-serif; }
h1 { font-size: 26px; margin: 0; } h2 { font-size: 18px; margin: 38px 0 12px; padding-bottom: 5px;
  border-bottom: 1px solid var(--rule); }
.payload { font-family: ui-monospace, "Liberation Mono", monospace; color: var(--accent);
  overflow-wrap: anywhere; }
.chips { display: flex; flex-wrap: wrap; gap: 8px; margin: 14px 0 20px; padding: 0; list-style: none; }
.chips li { border: 1px solid var(--rule); border-radius: 14px; padding: 2px 11px; font-size: 13px; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(330px, 1fr)); gap: 22px;
  align-items: start; }
.pair + .pair { margin-top: 20px; }
figure { margin: 0; } figcaption { color: var(--soft); font-size: 13px; margin-top: 6px; }
figure img, figure svg { display: block; width: 100%; height: auto; border-radius: 4px; }
.plan svg { background: #30353c; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 400; color: var(--soft); padding: 3px 14px 3px 0; vertical-align: top; }
td { padding: 3px 0; } tbody th:first-child { width: 46%; }
.heat tbody th:first-child { width: auto; } thead th { border-bottom: 1px solid var(--rule); }
tr + tr > * { border-top: 1px solid #f0f2f4; }
.heat td { text-align: center; color: #fff; padding: 4px 8px; border: 2px solid #fff; }
.heat td:last-child { text-align: left; color: var(--soft); }
.heat thead th { text-align: center; padding: 3px 8px; } .advice { padding-left: 20px; }
.chart text { font-size: 11px; fill: var(--soft); } .chart polyline { fill: none; }
.axis { stroke: #b8bfc6; } .line { stroke: var(--accent); stroke-width: 2; }
.limit { stroke: #d1342f; stroke-dasharray: 5 4; }
@media print { body { padding: 0; } h2 { break-after: avoid; } figure { break-inside: avoid; } }
"""
