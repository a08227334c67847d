# cmake -DOUT=F -DWHAT="what they are" -DNAMESPACE=ulf::n -DFILES="a;b" -P embed.cmake: writes the files' text to F as string
# constants named after the files.
set(text "// Made from ${WHAT} by embed.cmake.\n#pragma once\nnamespace ${NAMESPACE} {\n")
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME)
  string(REPLACE "." "_" name ${name})
  file(READ ${file} content)
  string(APPEND text "inline constexpr char k_${name}[] = R\"GLSL(${content})GLSL\";\n")
endforeach()
string(APPEND text "}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUT} "${text}")
