// NiceGUI 3.18.0
deltactlTemplates.set("const _Vue = Vue\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue\n\n    return (_openBlock(), _createElementBlock(\"div\"))\n  }\n}", function (Vue) {
const _Vue = Vue

return function render(_ctx, _cache) {
  with (_ctx) {
    const { openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue

    return (_openBlock(), _createElementBlock("div"))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\nconst { createElementVNode: _createElementVNode } = _Vue\n\nconst _hoisted_1 = { class: \"nicegui-expansion-content\" }\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, createElementVNode: _createElementVNode, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue\n\n    const _component_q_expansion_item = _resolveComponent(\"q-expansion-item\")\n\n    return (_openBlock(), _createBlock(_component_q_expansion_item, { ref: \"qRef\" }, _createSlots({\n      default: _withCtx(() => [_createElementVNode(\"div\", _hoisted_1, [_renderSlot($slots, \"default\")])]),\n      _: 2\n    }, [_renderList(nonDefaultSlots, (_, name) => {\n      return {\n        name: name,\n        fn: _withCtx((slotProps) => [_renderSlot($slots, name, _normalizeProps(_guardReactiveProps(slotProps || {})))])\n      }\n    })]), 1536))\n  }\n}", function (Vue) {
const _Vue = Vue
const { createElementVNode: _createElementVNode } = _Vue

const _hoisted_1 = { class: "nicegui-expansion-content" }

return function render(_ctx, _cache) {
  with (_ctx) {
    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, createElementVNode: _createElementVNode, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue

    const _component_q_expansion_item = _resolveComponent("q-expansion-item")

    return (_openBlock(), _createBlock(_component_q_expansion_item, { ref: "qRef" }, _createSlots({
      default: _withCtx(() => [_createElementVNode("div", _hoisted_1, [_renderSlot($slots, "default")])]),
      _: 2
    }, [_renderList(nonDefaultSlots, (_, name) => {
      return {
        name: name,
        fn: _withCtx((slotProps) => [_renderSlot($slots, name, _normalizeProps(_guardReactiveProps(slotProps || {})))])
      }
    })]), 1536))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, openBlock: _openBlock, createBlock: _createBlock } = _Vue\n\n    const _component_q_header = _resolveComponent(\"q-header\")\n\n    return (_openBlock(), _createBlock(_component_q_header, { ref: \"qRef\" }, {\n      default: _withCtx(() => [_renderSlot($slots, \"default\")]),\n      _: 3\n    }, 512))\n  }\n}", function (Vue) {
const _Vue = Vue

return function render(_ctx, _cache) {
  with (_ctx) {
    const { renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, openBlock: _openBlock, createBlock: _createBlock } = _Vue

    const _component_q_header = _resolveComponent("q-header")

    return (_openBlock(), _createBlock(_component_q_header, { ref: "qRef" }, {
      default: _withCtx(() => [_renderSlot($slots, "default")]),
      _: 3
    }, 512))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\nconst { createVNode: _createVNode, createCommentVNode: _createCommentVNode } = _Vue\n\nconst _hoisted_1 = [\"id\"]\nconst _hoisted_2 = [\"value\"]\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withKeys: _withKeys, mergeProps: _mergeProps, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, createVNode: _createVNode, Fragment: _Fragment, openBlock: _openBlock, createElementBlock: _createElementBlock, createCommentVNode: _createCommentVNode } = _Vue\n\n    const _component_q_input = _resolveComponent(\"q-input\")\n\n    return (_openBlock(), _createElementBlock(_Fragment, null, [_createVNode(_component_q_input, _mergeProps({ ref: \"qRef\" }, $attrs, {\n      modelValue: inputValue,\n      \"onUpdate:modelValue\": $event => ((inputValue) = $event),\n      \"shadow-text\": shadowText,\n      onKeydown: _withKeys(perform_autocomplete, [\"tab\"]),\n      list: id + '-datalist'\n    }), _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {\n      return {\n        name: slot,\n        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])\n      }\n    })]), 1040, [\"modelValue\", \"onUpdate:modelValue\", \"shadow-text\", \"onKeydown\", \"list\"]), withDatalist\n      ? (_openBlock(), _createElementBlock(\"datalist\", {\n          key: 0,\n          id: id + '-datalist'\n        }, [(_openBlock(true), _createElementBlock(_Fragment, null, _renderList(this._autocomplete, (option) => {\n          return (_openBlock(), _createElementBlock(\"option\", { value: option }, null, 8, _hoisted_2))\n        }), 256))], 8, _hoisted_1))\n      : _createCommentVNode(\"\", true)], 64))\n  }\n}", function (Vue) {
const _Vue = Vue
const { createVNode: _createVNode, createCommentVNode: _createCommentVNode } = _Vue

const _hoisted_1 = ["id"]
const _hoisted_2 = ["value"]

return function render(_ctx, _cache) {
  with (_ctx) {
    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withKeys: _withKeys, mergeProps: _mergeProps, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, createVNode: _createVNode, Fragment: _Fragment, openBlock: _openBlock, createElementBlock: _createElementBlock, createCommentVNode: _createCommentVNode } = _Vue

    const _component_q_input = _resolveComponent("q-input")

    return (_openBlock(), _createElementBlock(_Fragment, null, [_createVNode(_component_q_input, _mergeProps({ ref: "qRef" }, $attrs, {
      modelValue: inputValue,
      "onUpdate:modelValue": $event => ((inputValue) = $event),
      "shadow-text": shadowText,
      onKeydown: _withKeys(perform_autocomplete, ["tab"]),
      list: id + '-datalist'
    }), _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {
      return {
        name: slot,
        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])
      }
    })]), 1040, ["modelValue", "onUpdate:modelValue", "shadow-text", "onKeydown", "list"]), withDatalist
      ? (_openBlock(), _createElementBlock("datalist", {
          key: 0,
          id: id + '-datalist'
        }, [(_openBlock(true), _createElementBlock(_Fragment, null, _renderList(this._autocomplete, (option) => {
          return (_openBlock(), _createElementBlock("option", { value: option }, null, 8, _hoisted_2))
        }), 256))], 8, _hoisted_1))
      : _createCommentVNode("", true)], 64))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\nconst {  } = _Vue\n\nconst _hoisted_1 = [\"href\", \"target\"]\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { renderSlot: _renderSlot, openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue\n\n    return (_openBlock(), _createElementBlock(\"a\", {\n      href: computed_href,\n      target: target\n    }, [_renderSlot($slots, \"default\")], 8, _hoisted_1))\n  }\n}", function (Vue) {
const _Vue = Vue
const {  } = _Vue

const _hoisted_1 = ["href", "target"]

return function render(_ctx, _cache) {
  with (_ctx) {
    const { renderSlot: _renderSlot, openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue

    return (_openBlock(), _createElementBlock("a", {
      href: computed_href,
      target: target
    }, [_renderSlot($slots, "default")], 8, _hoisted_1))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\nconst { createElementVNode: _createElementVNode } = _Vue\n\nconst _hoisted_1 = {\n  style: {\"position\":\"relative\"},\n  \"data-initializing\": \"\"\n}\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { createElementVNode: _createElementVNode, openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue\n\n    return (_openBlock(), _createElementBlock(\"div\", _hoisted_1, [...(_cache[0] || (_cache[0] = [\n      _createElementVNode(\"canvas\", { style: {\"position\":\"relative\"} }, null, -1),\n      _createElementVNode(\"div\", { style: {\"position\":\"absolute\",\"pointer-events\":\"none\",\"top\":\"0\"} }, null, -1),\n      _createElementVNode(\"div\", { style: {\"position\":\"absolute\",\"pointer-events\":\"none\",\"top\":\"0\"} }, null, -1),\n      _createElementVNode(\"div\", { style: {\"position\":\"absolute\",\"display\":\"none\",\"inset\":\"0\",\"cursor\":\"pointer\"} }, \"WebGL context lost. Click to re-initialize.\", -1)\n    ]))]))\n  }\n}", function (Vue) {
const _Vue = Vue
const { createElementVNode: _createElementVNode } = _Vue

const _hoisted_1 = {
  style: {"position":"relative"},
  "data-initializing": ""
}

return function render(_ctx, _cache) {
  with (_ctx) {
    const { createElementVNode: _createElementVNode, openBlock: _openBlock, createElementBlock: _createElementBlock } = _Vue

    return (_openBlock(), _createElementBlock("div", _hoisted_1, [...(_cache[0] || (_cache[0] = [
      _createElementVNode("canvas", { style: {"position":"relative"} }, null, -1),
      _createElementVNode("div", { style: {"position":"absolute","pointer-events":"none","top":"0"} }, null, -1),
      _createElementVNode("div", { style: {"position":"absolute","pointer-events":"none","top":"0"} }, null, -1),
      _createElementVNode("div", { style: {"position":"absolute","display":"none","inset":"0","cursor":"pointer"} }, "WebGL context lost. Click to re-initialize.", -1)
    ]))]))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue\n\n    const _component_q_select = _resolveComponent(\"q-select\")\n\n    return (_openBlock(), _createBlock(_component_q_select, {\n      ref: \"qRef\",\n      options: filteredOptions,\n      onFilter: filterFn,\n      onPopupShow: addClass,\n      onPopupHide: removeClass,\n      onInputValue: forwardInputValue,\n      \"onUpdate:modelValue\": forwardModelValue\n    }, _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {\n      return {\n        name: slot,\n        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])\n      }\n    })]), 1032, [\"options\", \"onFilter\", \"onPopupShow\", \"onPopupHide\", \"onInputValue\", \"onUpdate:modelValue\"]))\n  }\n}", function (Vue) {
const _Vue = Vue

return function render(_ctx, _cache) {
  with (_ctx) {
    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue

    const _component_q_select = _resolveComponent("q-select")

    return (_openBlock(), _createBlock(_component_q_select, {
      ref: "qRef",
      options: filteredOptions,
      onFilter: filterFn,
      onPopupShow: addClass,
      onPopupHide: removeClass,
      onInputValue: forwardInputValue,
      "onUpdate:modelValue": forwardModelValue
    }, _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {
      return {
        name: slot,
        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])
      }
    })]), 1032, ["options", "onFilter", "onPopupShow", "onPopupHide", "onInputValue", "onUpdate:modelValue"]))
  }
}
});
deltactlTemplates.set("const _Vue = Vue\n\nreturn function render(_ctx, _cache) {\n  with (_ctx) {\n    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue\n\n    const _component_q_uploader = _resolveComponent(\"q-uploader\")\n\n    return (_openBlock(), _createBlock(_component_q_uploader, {\n      ref: \"qRef\",\n      url: computed_url\n    }, _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {\n      return {\n        name: slot,\n        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])\n      }\n    })]), 1032, [\"url\"]))\n  }\n}", function (Vue) {
const _Vue = Vue

return function render(_ctx, _cache) {
  with (_ctx) {
    const { normalizeProps: _normalizeProps, guardReactiveProps: _guardReactiveProps, renderSlot: _renderSlot, resolveComponent: _resolveComponent, withCtx: _withCtx, renderList: _renderList, createSlots: _createSlots, openBlock: _openBlock, createBlock: _createBlock } = _Vue

    const _component_q_uploader = _resolveComponent("q-uploader")

    return (_openBlock(), _createBlock(_component_q_uploader, {
      ref: "qRef",
      url: computed_url
    }, _createSlots({ _: 2 }, [_renderList($slots, (_, slot) => {
      return {
        name: slot,
        fn: _withCtx((slotProps) => [_renderSlot($slots, slot, _normalizeProps(_guardReactiveProps(slotProps || {})))])
      }
    })]), 1032, ["url"]))
  }
}
});
