#pragma once

namespace backsight {

/// Has blocks of megabytes, which stand for whole scans, go back to the system as soon as they are
/// freed. The allocator would otherwise keep more and more of them, up to the largest it has seen.
/// For the whole program, at its start; overrides the environment of the allocator.
void ReturnLargeBlocksAtOnce();

/// Gives memory that was freed back to the system, which the allocator otherwise keeps thread by
/// thread. To be called where something large has ended; some milliseconds.
void ReturnFreeMemory();

}  // namespace backsight
