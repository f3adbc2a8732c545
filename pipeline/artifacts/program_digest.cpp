#include "pipeline/artifacts/program_digest.h"

#include <elf.h>
#include <link.h>
#include <sys/auxv.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/fingerprint.h"

namespace backsight {
namespace {

/// Adds the build identifier among the notes, which a linker makes from a library's content.
void AddBuildId(const char* notes, std::size_t size, std::vector<std::string>* ids) {
  std::size_t at = 0;
  const auto padded = [](std::size_t bytes) { return (bytes + 3) / 4 * 4; };
  while (at + sizeof(ElfW(Nhdr)) <= size) {
    const auto* note = reinterpret_cast<const ElfW(Nhdr)*>(notes + at);
    const char* content = notes + at + sizeof(ElfW(Nhdr)) + padded(note->n_namesz);
    if (note->n_type == NT_GNU_BUILD_ID) ids->emplace_back(content, note->n_descsz);
    at += sizeof(ElfW(Nhdr)) + padded(note->n_namesz) + padded(note->n_descsz);
  }
}

/// The kernel's own pages, which look like a library.
bool IsOfKernel(const dl_phdr_info& info) {
  return info.dlpi_addr != 0 && info.dlpi_addr == ::getauxval(AT_SYSINFO_EHDR);
}

int AddLibrary(dl_phdr_info* info, std::size_t, void* ids) {
  if (IsOfKernel(*info)) return 0;
  for (const ElfW(Phdr) & header : std::span(info->dlpi_phdr, info->dlpi_phnum)) {
    if (header.p_type != PT_NOTE) continue;
    AddBuildId(reinterpret_cast<const char*>(info->dlpi_addr + header.p_vaddr), header.p_memsz,
               static_cast<std::vector<std::string>*>(ids));
  }
  return 0;
}

std::string MakeDigest() {
  std::vector<std::string> ids = {FingerprintFile("/proc/self/exe")};
  dl_iterate_phdr(AddLibrary, &ids);
  std::sort(ids.begin() + 1, ids.end());
  Fingerprint fingerprint;
  for (const std::string& id : ids) fingerprint.Add(std::string_view(id));
  return fingerprint.Hex();
}

}  // namespace

const std::string& ProgramDigest() {
  static const std::string digest = MakeDigest();
  return digest;
}

}  // namespace backsight
