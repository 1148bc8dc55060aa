"""What can be made to go wrong with a simulated VL53L1X."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class ChipFaults:
    """Knobs, all off at first; may be turned at any time. `clear` turns all off again."""

    nack_transfers: int = 0
    """So many of the next transfers are not acknowledged (errno 121)."""
    timeout_transfers: int = 0
    """So many of the next transfers time out (errno 110)."""
    io_error_transfers: int = 0
    """So many of the next transfers fail with an I/O error (errno 5)."""
    flip: tuple[int, int] | None = None
    """(byte, mask) to invert in what is read from it ..."""
    flip_reads: int = 0
    """... for so many reads that are long enough."""
    frozen: bool = False
    """Ranging goes on but the results, stream count included, no longer change."""
    raw_status: int | None = None
    """Status code of every sample."""
    stuck_m: float | None = None
    """Every sample is this distance, with a good status and a stream count that goes on."""
    held: bool = False
    """Every sample is the one before, in the same way: crosstalk of a dirty glass, say."""
    offset_m: float = 0.0
    """Added to every distance: the sensor has slipped on its mount."""
    scale: float = 1.0
    """Every distance is multiplied by this."""
    spike_rate: float = 0.0
    """This part of the samples, evenly spread, ..."""
    spike_m: float = 0.3
    """... is so much too far."""
    sda_stuck: bool = False
    """Holds SDA low: the whole bus times out. A reset (XSHUT low) frees it."""
    extra_boot_ns: int = 0
    """Boots so much later, silent (not acknowledging) ..."""
    deaf_firmware_ns: int = 0
    """... and then acknowledges so long before the firmware says that it has booted."""
    model_id: int | None = None
    """Answers with another model id (0x010F)."""
    no_osc_calibration: bool = False
    """RESULT__OSC_CALIBRATE_VAL reads 0."""
    silent_flag: bool = False
    """New samples no longer set the ready flag."""
    xshut_broken: bool = False
    """The XSHUT wire is open: the board's pull-up keeps it running."""
    unpowered: bool = False
    """No supply, or not there at all."""

    def clear(self) -> None:
        """Turn all knobs off."""
        self.__dict__.update(ChipFaults().__dict__)

    def shown_m(self, distance_m: float, sample: int, before_m: float) -> float:
        """What a sample of this number shows of a distance; `before_m` is what the last showed."""
        if self.stuck_m is not None:
            return self.stuck_m
        if self.held:
            return before_m
        spikes = int(sample * self.spike_rate) - int((sample - 1) * self.spike_rate)
        return distance_m * self.scale + self.offset_m + spikes * self.spike_m

    def transfer_errno(self) -> int | None:
        """The errno with which the next transfer fails, counting it; None when it does not."""
        if self.timeout_transfers > 0:
            self.timeout_transfers -= 1
            return 110
        if self.io_error_transfers > 0:
            self.io_error_transfers -= 1
            return 5
        if self.nack_transfers > 0:
            self.nack_transfers -= 1
            return 121
        return None

    def disturb(self, data: bytes) -> bytes:
        """Flip the bits asked for in what was read."""
        if self.flip is None or self.flip_reads <= 0 or len(data) <= self.flip[0]:
            return data
        self.flip_reads -= 1
        at, mask = self.flip
        return data[:at] + bytes([data[at] ^ mask]) + data[at + 1 :]
