"""report: one self-contained HTML page about one run. Figures are embedded; nothing is fetched when it is
opened.
"""

import argparse
import base64
import html
import io

from ratslam_tools import plotting, text_file
from ratslam_tools.cli import plot_run
from ratslam_tools.evaluation import error_plots
from ratslam_tools.runs import run_figures
from ratslam_tools.table import html_table

STYLE = """
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #222; background: #fff; max-width: 62rem;
       margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; border-bottom: 2px solid #0060a8; padding-bottom: .3rem; }
h2 { font-size: 1.2rem; margin-top: 2.2rem; }
figure { margin: 1rem 0; break-inside: avoid; }
figure img { width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .2rem .8rem; border-bottom: 1px solid #ddd; text-align: right; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 2px solid #888; }
.columns { column-width: 24rem; column-gap: 2rem; }
.columns table { width: 100%; break-inside: auto; }
@media print {
  body { max-width: none; margin: 0; font-size: 10pt; }
  h2 { break-after: avoid; }
  figure img { width: auto; max-width: 100%; max-height: 125mm; }
  .columns { columns: 2; column-gap: 6mm; }
  .columns table { font-size: 7.5pt; }
  .columns th, .columns td { padding: .05rem .3rem; overflow-wrap: anywhere; }
  tr { break-inside: avoid; }
  @page { size: A4; margin: 15mm; }
}
"""


def embedded(figure, caption: str) -> str:
    """A figure as an HTML element that carries its own picture."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    plotting.load().close(figure)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    text = html.escape(caption)
    return (
        f'<figure><img alt="{text}" src="data:image/png;base64,{data}">'
        f"<figcaption>{text}</figcaption></figure>"
    )


def flatten(value, prefix: str = "") -> list:
    """(dotted key, text) of everything in a nested dict or list."""
    if isinstance(value, dict):
        return [
            row
            for key, entry in value.items()
            for row in flatten(entry, f"{prefix}.{key}" if prefix else str(key))
        ]
    if isinstance(value, list) and any(isinstance(entry, (dict, list)) for entry in value):
        return [row for index, entry in enumerate(value) for row in flatten(entry, f"{prefix}[{index}]")]
    if isinstance(value, float):
        return [[prefix, f"{value:.6g}"]]
    if isinstance(value, bool):
        return [[prefix, str(value).lower()]]
    if isinstance(value, list):
        return [[prefix, ", ".join(map(str, value))]]
    return [[prefix, str(value)]]


def sections(aligned: run_figures.Aligned) -> list:
    """The page's parts, in order."""
    run = aligned.run
    parts = [f"<h1>{html.escape(run.name)}</h1>"]
    if aligned.results:
        parts += [
            "<h2>Error</h2>",
            html_table(run_figures.error_rows(aligned)),
            "<p>Absolute pose error against the truth after alignment by rotation, translation and scale. "
            "<em>online</em> "
            "is what was known at the time, <em>final</em> the finished map's opinion of the whole path; "
            "<em>ground</em> "
            "is the same projected to the ground plane.</p>",
        ]
        if len(run.final.stretches) > 1:
            parts.append(f"<p>{html.escape(run_figures.stretch_words(run))}.</p>")
        parts += [f"<p><strong>{html.escape(note)}.</strong></p>" for note in aligned.notes.values()]
    parts += ["<h2>Map</h2>", embedded(run_figures.map_figure(aligned), map_caption(aligned))]
    if aligned.results:
        figure = error_plots.errors_figure(plotting.load(), aligned.results, "", "APE [m]")
        parts += [
            "<h2>Error along the path</h2>",
            embedded(figure, "Trajectories coloured by APE, and APE over time."),
        ]
    others = run_figures.panels(run)
    if others:
        parts.append("<h2>Over time</h2>")
    for title, draw in others:
        figure, axes = plotting.load().subplots(figsize=(10, 3.2), constrained_layout=True)
        draw(axes, run)
        parts.append(embedded(figure, f"{title}: {draw.__doc__.strip().splitlines()[0]}"))
    for key, title in (("parameters", "Parameters"), ("counts", "Counts"), ("timing", "Timing")):
        if key in run.summary:
            parts.append(f"<h2>{title}</h2>\n" + table_of(run.summary[key]))
    rest = {key: value for key, value in run.summary.items() if key not in ("parameters", "counts", "timing")}
    if rest:
        parts.append("<h2>Run</h2>\n" + table_of(rest))
    return parts


def table_of(value) -> str:
    """A two-column table of a nested value, in newspaper columns."""
    return f'<div class="columns">{html_table([["key", "value"], *flatten(value)])}</div>'


def map_caption(aligned: run_figures.Aligned) -> str:
    """What the map shows, with counts."""
    text = "Final and online trajectory"
    if aligned.truth is not None:
        text = "Truth, final and online trajectory, each aligned to the truth"
    if aligned.run.map is not None:
        count = len(aligned.run.map.nodes["id"])
        links, loops = len(aligned.run.map.ends), len(aligned.run.map.loop_ends)
        text += f"; {count} experiences, {links} links, {loops} of them by recall"
    return text + "."


def page(aligned: run_figures.Aligned) -> str:
    """The whole HTML document."""
    body = "\n".join(sections(aligned))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(aligned.run.name)}</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n{body}\n</body>\n</html>\n"
    )


def main(argv=None) -> None:
    """report."""
    parser = argparse.ArgumentParser(
        prog="report",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="One self-contained HTML page about a run: errors, figures, parameters, timing.",
        epilog="examples:\n  report out/kitti_00\n  report out/kitti_00 --truth dataset/sequences/00 --out "
        "kitti_00.html",
    )
    plot_run.add_run_argument(parser)
    plot_run.add_truth_options(parser)
    parser.add_argument(
        "--out", metavar="FILE", help="page to write (default: RUN/report.html, or RUN_report.html if it is no folder)"
    )
    arguments = parser.parse_args(argv)
    path = arguments.out or plot_run.default_output(arguments.folder, "report.html")
    plot_run.require_own_output("--out", path, arguments.folder, arguments)
    text = page(plot_run.aligned_run(arguments))
    with text_file.writing(path) as file:
        file.write(text)
    print(f"wrote {path}")
