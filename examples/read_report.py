#!/usr/bin/env python3
"""Reads what render_map writes: report.json, the CSV files of --trace, and PFM pictures.

  python3 read_report.py report.json [FILE.csv | FILE.pfm]...

prints the frames of a report as a table, and what the other files hold. As a module, its functions return Python numbers and
lists, or NumPy arrays where NumPy is installed:

  import read_report
  report = read_report.load_report('report.json')
  psnr = read_report.column(report, 'photograph.psnr_db')     # one number per frame; None where a frame has none
  tiles = read_report.load_csv('trace/frame_0000.tiles.csv')  # {name of a column: its values}
  picture = read_report.load_pfm('tilemesh_out/frame_0000.pfm')  # picture[row][column][channel], from the top left
"""
import array
import csv
import json
import sys

try:
    import numpy
except ImportError:
    numpy = None


def as_array(values):
    """A NumPy array of the values, or the values as they are where NumPy is absent."""
    return values if numpy is None else numpy.asarray(values)


def load_report(path):
    """report.json as dictionaries and lists. Refuses a form that this file does not know."""
    with open(path, encoding='utf-8') as file:
        report = json.load(file)
    if not isinstance(report, dict) or report.get('schema') != 2:
        raise ValueError(f'{path} is no report of schema 2; use the read_report.py of the version that wrote it')
    return report


def member(frame, name):
    """A member of a frame by its path, for example "gaussians.visible"; None if the frame has no such member."""
    for part in name.split('.'):
        frame = frame.get(part) if isinstance(frame, dict) else None
    return frame


def column(report, name):
    """A member of all frames, one value per frame."""
    values = [member(frame, name) for frame in report['frames']]
    return values if None in values else as_array(values)


def number(text):
    """The number that a text is, or the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def load_csv(path):
    """A CSV file of --trace: a dictionary of its columns, by their names."""
    with open(path, newline='', encoding='utf-8') as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ValueError(f'{path} has no header')
    columns = {name: [number(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}
    return {name: values if any(isinstance(v, str) for v in values) else as_array(values) for name, values in columns.items()}


def load_pfm(path):
    """A PFM picture, its rows from the top: picture[row][column][channel] of a colour PFM, picture[row][column] of a grey one."""
    with open(path, 'rb') as file:
        magic, size, scale = (file.readline().split() for _ in range(3))
        data = file.read()
    if magic not in ([b'PF'], [b'Pf']) or len(size) != 2 or len(scale) != 1:
        raise ValueError(f'{path} is no PFM picture')
    width, height = map(int, size)
    channels = 3 if magic == [b'PF'] else 1
    values = array.array('f')
    if len(data) != 4 * width * height * channels:
        raise ValueError(f'{path} has {len(data)} bytes of pixels, not those of {width} x {height}')
    values.frombytes(data)
    if (float(scale[0]) < 0) != (sys.byteorder == 'little'):
        values.byteswap()
    if numpy is not None:
        shape = (height, width, 3) if channels == 3 else (height, width)
        return numpy.array(values, dtype=numpy.float32).reshape(shape)[::-1]
    rows = [values[y * width * channels:(y + 1) * width * channels] for y in reversed(range(height))]
    if channels == 1:
        return [row.tolist() for row in rows]
    return [[row[3 * x:3 * x + 3].tolist() for x in range(width)] for row in rows]


# The columns of the table: a title, a member, a format.
COLUMNS = (('camera', 'camera', '{}'), ('program', 'program', '{}'), ('visible', 'gaussians.visible', '{:,}'), ('pairs', 'pairs', '{:,}'),
           ('host ms', 'host_ms.total', '{:.1f}'), ('modelled ms', 'modelled.ms', '{:.3f}'), ('PSNR, dB', 'photograph.psnr_db', '{:.2f}'),
           ('SSIM', 'photograph.ssim', '{:.4f}'), ('L1', 'photograph.l1', '{:.4f}'))


def table(report):
    """The frames of a report as lines of text; a column that no frame has is left out."""
    used = [c for c in COLUMNS if any(member(frame, c[1]) is not None for frame in report['frames'])]
    cells = [['frame'] + [title for title, _, _ in used]]
    for i, frame in enumerate(report['frames']):
        values = ((form, member(frame, name)) for _, name, form in used)
        cells.append([str(i)] + ['' if value is None else form.format(value) for form, value in values])
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    lines = ['  '.join(cell.ljust(width) if i == 1 else cell.rjust(width) for i, (cell, width) in enumerate(zip(row, widths))) for row in cells]
    means = report.get('photographs')
    if means and means['compared']:
        psnr = 'infinite' if means['psnr_db'] is None else f"{means['psnr_db']:.2f} dB"
        lines.append(f"mean of {means['compared']} photographs: PSNR {psnr}, SSIM {means['ssim']:.4f}, L1 {means['l1']:.4f}")
    return '\n'.join(line.rstrip() for line in lines)


def describe(path):
    """What a file holds, as text."""
    if path.endswith('.csv'):
        columns = load_csv(path)
        rows = len(next(iter(columns.values()), []))
        return f'{path}: {rows} rows of ' + ', '.join(columns)
    if path.endswith('.pfm'):
        picture = load_pfm(path)
        pixels = [pixel for row in picture for pixel in row]
        channels = [value for pixel in pixels for value in (pixel if hasattr(pixel, '__len__') else [pixel])]
        return f'{path}: {len(picture[0])} x {len(picture)} pixels, values {min(channels):g} to {max(channels):g}'
    report = load_report(path)
    lines = [f"{path}: map {report['map']['name']}, {report['map']['gaussians']:,} Gaussians"] + report['notes'] + [table(report)]
    return '\n'.join(lines)


def main(paths):
    if not paths:
        print(__doc__.strip())
        return 2
    for path in paths:
        try:
            print(describe(path))
        except (OSError, ValueError, KeyError) as error:
            print(f'read_report: {error}', file=sys.stderr)
            return 2
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
