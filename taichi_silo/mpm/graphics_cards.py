"""The graphics cards of this machine, as their drivers name them; asked before Taichi is started on one.

Taichi itself falls back to the processor without a word where it finds no Vulkan device, and ends the process at the
first number of 64 bits where a card has none.
"""

import contextlib
import ctypes
import os
import sys
from typing import NamedTuple

VULKAN_LIBRARIES = {"win32": "vulkan-1.dll", "darwin": "libvulkan.1.dylib"}  # else libvulkan.so.1
CUDA_LIBRARIES = {"win32": "nvcuda.dll"}  # else libcuda.so.1
CHOICE = "TI_VISIBLE_DEVICE"  # environment variable of Taichi: number of the card that Vulkan is to use
# VkPhysicalDeviceType, the fastest kind first
KINDS = {2: "discrete card", 1: "integrated card", 3: "virtual card", 0: "other device", 4: "software driver"}
MOST = 16  # cards that are looked at
PROPERTIES, TYPE_AT, NAME_AT, NAME_BYTES = 4096, 16, 20, 256  # of VkPhysicalDeviceProperties, with room [bytes]
BUFFERS_AT = 372  # of its limits, maxPerStageDescriptorStorageBuffers
FEATURES, FLOAT64 = 256, 39  # of VkPhysicalDeviceFeatures: room [words], and which of them is shaderFloat64


class Card(NamedTuple):
    """A device that Vulkan offers."""

    number: int  # by which the driver counts it
    name: str
    kind: str  # of KINDS
    f64: bool  # whether its shaders compute with 64 bits
    buffers: int  # pieces of memory that a shader may see: trees of fields


def vulkan_cards() -> list[Card]:
    """All devices that Vulkan offers, the fastest kind first; none where it is not installed."""
    try:
        library = ctypes.CDLL(VULKAN_LIBRARIES.get(sys.platform, "libvulkan.so.1"))
    except OSError:
        return []
    wanted = (ctypes.c_uint64 * 8)(1)  # VkInstanceCreateInfo: its type, and nothing in particular
    instance = ctypes.c_void_p()
    if library.vkCreateInstance(wanted, None, ctypes.byref(instance)) != 0:
        return []
    try:
        count, devices = ctypes.c_uint32(MOST), (ctypes.c_void_p * MOST)()
        if library.vkEnumeratePhysicalDevices(instance, ctypes.byref(count), devices) < 0:
            return []
        cards = [_card(library, number, devices[number]) for number in range(count.value)]
    finally:
        library.vkDestroyInstance(instance, None)
    return sorted(cards, key=lambda card: list(KINDS.values()).index(card.kind))


def _card(library: ctypes.CDLL, number: int, device: int | None) -> Card:
    properties, features = ctypes.create_string_buffer(PROPERTIES), (ctypes.c_uint32 * FEATURES)()
    library.vkGetPhysicalDeviceProperties(ctypes.c_void_p(device), properties)
    library.vkGetPhysicalDeviceFeatures(ctypes.c_void_p(device), features)
    kind = KINDS.get(int.from_bytes(properties.raw[TYPE_AT : TYPE_AT + 4], sys.byteorder), KINDS[0])
    name = properties.raw[NAME_AT : NAME_AT + NAME_BYTES].split(b"\0")[0].decode("utf-8", "replace")
    buffers = int.from_bytes(properties.raw[BUFFERS_AT : BUFFERS_AT + 4], sys.byteorder)
    return Card(number, name, kind, bool(features[FLOAT64]), buffers)


def chosen(cards: list[Card]) -> Card | None:
    """The card that TI_VISIBLE_DEVICE names, or else the fastest kind that computes in f64; None if there is none."""
    with contextlib.suppress(ValueError):
        wanted = int(os.environ.get(CHOICE, ""))
        return next((card for card in cards if card.number == wanted and card.f64), None)
    return next((card for card in cards if card.f64), None)


def cuda_card() -> str:
    """Name of the first card that CUDA offers; empty where none answers."""
    try:
        library = ctypes.CDLL(CUDA_LIBRARIES.get(sys.platform, "libcuda.so.1"))
        device, name = ctypes.c_int(), ctypes.create_string_buffer(NAME_BYTES)
        if library.cuInit(0) or library.cuDeviceGet(ctypes.byref(device), 0):
            return ""
        return "" if library.cuDeviceGetName(name, NAME_BYTES, device) else name.value.decode("utf-8", "replace")
    except (OSError, AttributeError):
        return ""
