"""How the page looks: on a desk, on a phone, in the dark and on paper."""

STYLE = """
.stop-button { position: fixed; top: 4px; right: 8px; z-index: 9900; min-width: 7rem;
  font-size: 1.15rem; font-weight: 800; height: 42px; box-shadow: 0 0 0 2px white; }
.stop-room { min-width: 7.5rem; }
.latch { z-index: 1500; background: #b91c1c; color: white; padding: 8px 12px; border-radius: 6px;
  position: sticky; top: 52px; }
.news { background: #fef3c7; color: #78350f; padding: 8px 12px; border-radius: 6px; }
.scene-box { height: min(56vh, 520px); min-height: 260px; }
.editor { height: max(24rem, 100vh - 130px); }
.no-webgl { display: none; color: #78350f; } .without-webgl .no-webgl { display: block; }
.without-webgl .scene-box, .without-webgl .scene-caption { display: none; }
.figures { font-variant-numeric: tabular-nums; }
.q-btn.disabled { outline: 1px dashed #94a3b8; outline-offset: -1px; box-shadow: none; }
.q-btn.disabled::before { border-color: transparent; box-shadow: none; }
.q-btn.disabled .block { text-decoration: line-through; }
.jog .q-btn { min-width: 46px; min-height: 42px; }
@media (hover: none) and (pointer: coarse) { .with-keys { display: none; } }
@media (max-width: 599px) { .scene-box { height: 36vh; min-height: 220px; }
  .editor { height: 24rem; }
  .stop-button { top: auto; bottom: 0; left: 0; right: 0; height: 60px; border-radius: 0; }
  .q-notifications__list--bottom { bottom: 64px; }
  .stop-room { min-width: 0; } .q-page-container { padding-bottom: 84px; }
  .nicegui-content { padding: 4px; padding-bottom: 90px; } }
"""

DARK = """
.body--dark .text-gray-600 { color: #94a3b8; } .body--dark .text-red-800 { color: #fca5a5; }
.body--dark .text-green-800 { color: #86efac; } .body--dark a { color: #93c5fd; }
.body--dark .q-btn--outline, .body--dark .q-tab-panel .q-btn--flat { --q-primary: #93c5fd; }
.body--dark .q-btn--outline.disabled { filter: brightness(2.4); }
.body--dark .scene-box, .body--dark .editor { filter: invert(0.9) hue-rotate(180deg); }
"""
"""Where the browser asks for it. The drawing and the editor know bright colours only: turned over,
and then each hue turned back."""

PAPER = """
@media print { .stop-button, .q-tabs, .q-btn, .q-card.jog,
  .q-card.conceal, .stop-room { display: none !important; }
  .q-header { position: static; background: none !important; color: black; padding: 0; }
  .q-page-container { padding: 0 !important; } .latch { position: static; }
  .q-badge, .latch, .q-linear-progress, .news { print-color-adjust: exact; }
  .q-tab-panels, .q-panel, .q-tab-panel { overflow: visible !important; display: block; }
  .scene-box { zoom: 0.8; } .q-tab-panel > .row { display: block; }
  .q-tab-panel > .row > * + * { margin-top: 8px; }
  .q-card { box-shadow: none; border: 1px solid #cbd5e1; break-inside: avoid; }
  .editor, .editor .cm-editor, .editor .cm-scroller { height: auto !important; overflow: visible; }
  body.body--dark { background: white !important; color: black !important; }
  .body--dark .q-card { background: white; color: black; }
  .body--dark .scene-box, .body--dark .editor { filter: none; } }
"""
"""What can only be pressed stays off the paper."""
