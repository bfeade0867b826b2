"""make_graph replaces a file that it made earlier only if the file was not edited."""
from __future__ import annotations

import pytest

from graph_editor.errors import SiteError
from graph_editor.graph_files import is_as_made, write_made_graph
from trajectory_graph import Edge, Graph, Vertex, load_graph


def graph(length: float = 2.0) -> Graph:
    return Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, length, 0.0, 0.0)], [Edge(1, 1, 2)])


def test_a_made_file_is_loaded_and_may_be_made_again(tmp_path):
    path = str(tmp_path / 'graph.yaml')
    write_made_graph(graph(), path, ['a comment'], force=False)
    assert is_as_made(path)
    write_made_graph(graph(3.0), path, [], force=False)
    assert load_graph(path).vertices[2].x == 3.0


@pytest.mark.parametrize('edit', [
    lambda text: text.replace('X: 2.0', 'X: 2.5'), lambda text: text + '# mine\n',
    lambda text: text.partition('\n')[2], lambda text: text.replace('\n', '\r\n'),
    lambda text: text.replace('# a comment\n', ''), lambda text: ''])
def test_an_edited_file_is_not_overwritten_but_by_force(tmp_path, edit):
    path = tmp_path / 'graph.yaml'
    write_made_graph(graph(), str(path), ['a comment'], force=False)
    edited = edit(path.read_bytes().decode()).encode()
    path.write_bytes(edited)
    with pytest.raises(SiteError, match='--force'):
        write_made_graph(graph(), str(path), [], force=False)
    assert path.read_bytes() == edited
    write_made_graph(graph(), str(path), [], force=True)
    assert is_as_made(str(path))


def test_a_file_that_is_no_text_is_nobodys_to_overwrite(tmp_path):
    path = tmp_path / 'graph.yaml'
    path.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(SiteError, match='--force'):
        write_made_graph(graph(), str(path), [], force=False)


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(SiteError, match='cannot be written'):
        write_made_graph(graph(), str(tmp_path / 'no' / 'graph.yaml'), [], force=False)
