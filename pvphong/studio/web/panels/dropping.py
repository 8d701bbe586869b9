"""Files dropped onto the page: they are uploaded as by the file inputs, and a hint says what will happen."""

from __future__ import annotations

from trame.widgets import html

from pvphong.studio.web.inputs import found_by

STATE = {"dropping": ""}
"""State of each browser: "open" or "beside" while files are dragged over the page, else ""."""

STYLE = """
.studio-drop { position: fixed; inset: 12px; z-index: 3000; pointer-events: none; display: flex; align-items: center;
  justify-content: center; text-align: center; border: 3px dashed rgb(var(--v-theme-primary)); border-radius: 12px;
  background: rgba(var(--v-theme-surface), .8); padding: 16px }
"""

SCRIPT = """
(() => {
  let over;
  const state = () => window.trame.state;
  const hint = (what) => state().get('dropping') === what || state().set('dropping', what);
  const isOurs = ({ dataTransfer, target }) => dataTransfer && [...dataTransfer.types].includes('Files')
    && (!target.closest('.v-file-input') || target.closest('.studio-beside'));
  const isBeside = (event) => event.shiftKey || !!event.target.closest('.studio-beside');
  const kind = (file) => state().get('dropped')[(/[.][^.]+$/.exec(file.name) || [''])[0].toLowerCase()];
  const bring = (file, isBeside) => {
    const what = kind(file);
    if (!what) return window.trame.trigger('refuse_file', [file.name]);
    const more = isBeside && what === 'mesh' ? '&beside=1' : '';
    state().set('busy', true);
    return fetch('bring/' + what + '?name=' + encodeURIComponent(file.name) + more, { method: 'POST', body: file })
      .catch(() => {}).finally(() => state().set('busy', false));
  };
  window.addEventListener('dragover', (event) => {
    if (!isOurs(event)) return;
    event.preventDefault();
    hint(isBeside(event) ? 'beside' : 'open');
    clearTimeout(over);
    over = setTimeout(() => hint(''), 800);
  }, true);
  window.addEventListener('drop', async (event) => {
    if (!isOurs(event)) return;
    event.preventDefault();
    event.stopPropagation();
    clearTimeout(over);
    hint('');
    const files = [...event.dataTransfer.files];
    let addsMesh = isBeside(event);
    for (const file of files) {
      await bring(file, addsMesh);
      addsMesh ||= kind(file) === 'mesh';
    }
  }, true);
})();
"""
"""JavaScript that uploads dropped files one after the other: the first mesh is opened, further ones are added.
Drops onto a file input are left to the browser, except onto the one that adds a mesh. `dragover` is repeated until the
drag ends.
"""


def hint() -> None:
    """Add the hint that covers the page while files are dragged over it."""
    with html.Div(v_if="dropping", classes="studio-drop", **found_by("drop-hint", status=True)), html.Div():
        html.Div(
            "{{ dropping == 'beside' || !has_mesh ? 'Drop to ' + (has_mesh ? 'add the mesh beside the others'"
            " : 'open the mesh') : 'Drop to open the mesh; hold Shift to add it beside the others' }}",
            classes="text-h6",
        )
        html.Div("A rig (.json) sets lights and materials, a measured lamp (.ies, .ldt) is added.")
