// The simulated camera's description of itself, as a GenICam client downloads it (GenApi schema 1.0).
// Addresses are those of the register file behind Aravis's fake camera; Gain is kept in tenths of a decibel
// at 0x110.
#pragma once

namespace ulf::acquisition {

inline constexpr char kGenicamDescription[] = R"xml(<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription ModelName="HandheldSimulator" VendorName="ULF" StandardNameSpace="GEV"
  ToolTip="Simulated hand-held camera of ulf" SchemaMajorVersion="1" SchemaMinorVersion="0" SchemaSubMinorVersion="1"
  MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="7A0C1C52-3B1E-4B0B-9C55-0B0F53C6A001"
  VersionGuid="7A0C1C52-3B1E-4B0B-9C55-0B0F53C6A002" xmlns="http://www.genicam.org/GenApi/Version_1_0">

  <Category Name="Root" NameSpace="Standard">
    <pFeature>DeviceControl</pFeature>
    <pFeature>ImageFormatControl</pFeature>
    <pFeature>AcquisitionControl</pFeature>
    <pFeature>AnalogControl</pFeature>
    <pFeature>LastFrame</pFeature>
    <pFeature>TransportLayerControl</pFeature>
  </Category>

  <Category Name="DeviceControl" NameSpace="Standard">
    <pFeature>DeviceVendorName</pFeature>
    <pFeature>DeviceModelName</pFeature>
    <pFeature>DeviceManufacturerInfo</pFeature>
    <pFeature>DeviceVersion</pFeature>
    <pFeature>DeviceSerialNumber</pFeature>
  </Category>
  <StringReg Name="DeviceVendorName" NameSpace="Standard">
    <Address>0x48</Address><Length>32</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
  </StringReg>
  <StringReg Name="DeviceModelName" NameSpace="Standard">
    <Address>0x68</Address><Length>32</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
  </StringReg>
  <StringReg Name="DeviceVersion" NameSpace="Standard">
    <Address>0x88</Address><Length>32</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
  </StringReg>
  <StringReg Name="DeviceManufacturerInfo" NameSpace="Standard">
    <Address>0xa8</Address><Length>48</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
  </StringReg>
  <StringReg Name="DeviceSerialNumber" NameSpace="Standard">
    <Address>0xd8</Address><Length>16</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
  </StringReg>

  <Category Name="ImageFormatControl" NameSpace="Standard">
    <pFeature>SensorWidth</pFeature>
    <pFeature>SensorHeight</pFeature>
    <pFeature>Width</pFeature>
    <pFeature>Height</pFeature>
    <pFeature>OffsetX</pFeature>
    <pFeature>OffsetY</pFeature>
    <pFeature>PixelFormat</pFeature>
  </Category>
  <IntReg Name="SensorWidth" NameSpace="Standard">
    <Description>Width of the sensor, in pixels.</Description>
    <Address>0x11c</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <IntReg Name="SensorHeight" NameSpace="Standard">
    <Description>Height of the sensor, in pixels.</Description>
    <Address>0x118</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Integer Name="Width" NameSpace="Standard">
    <Description>Width of the part of the sensor that is sent, in pixels.</Description>
    <pValue>WidthReg</pValue><Min>16</Min><pMax>SensorWidth</pMax><Inc>2</Inc>
  </Integer>
  <IntReg Name="WidthReg" NameSpace="Custom">
    <Address>0x100</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Integer Name="Height" NameSpace="Standard">
    <Description>Height of the part of the sensor that is sent, in pixels.</Description>
    <pValue>HeightReg</pValue><Min>16</Min><pMax>SensorHeight</pMax><Inc>2</Inc>
  </Integer>
  <IntReg Name="HeightReg" NameSpace="Custom">
    <Address>0x104</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Integer Name="OffsetX" NameSpace="Standard">
    <Description>Left edge of the part that is sent, in pixels.</Description>
    <pValue>OffsetXReg</pValue><Min>0</Min><pMax>OffsetXMax</pMax><Inc>2</Inc>
  </Integer>
  <IntSwissKnife Name="OffsetXMax" NameSpace="Custom">
    <pVariable Name="ALL">SensorWidth</pVariable><pVariable Name="PART">Width</pVariable>
    <Formula>ALL - PART</Formula>
  </IntSwissKnife>
  <IntReg Name="OffsetXReg" NameSpace="Custom">
    <Address>0x130</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Integer Name="OffsetY" NameSpace="Standard">
    <Description>Top edge of the part that is sent, in pixels.</Description>
    <pValue>OffsetYReg</pValue><Min>0</Min><pMax>OffsetYMax</pMax><Inc>2</Inc>
  </Integer>
  <IntSwissKnife Name="OffsetYMax" NameSpace="Custom">
    <pVariable Name="ALL">SensorHeight</pVariable><pVariable Name="PART">Height</pVariable>
    <Formula>ALL - PART</Formula>
  </IntSwissKnife>
  <IntReg Name="OffsetYReg" NameSpace="Custom">
    <Address>0x134</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Enumeration Name="PixelFormat" NameSpace="Standard">
    <Description>How a pixel is sent; all formats are linear in light.</Description>
    <EnumEntry Name="Mono8" NameSpace="Standard"><Value>0x01080001</Value></EnumEntry>
    <EnumEntry Name="Mono10" NameSpace="Standard"><Value>0x01100003</Value></EnumEntry>
    <EnumEntry Name="Mono10p" NameSpace="Standard"><Value>0x010A0046</Value></EnumEntry>
    <EnumEntry Name="Mono12" NameSpace="Standard"><Value>0x01100005</Value></EnumEntry>
    <EnumEntry Name="Mono12p" NameSpace="Standard"><Value>0x010C0047</Value></EnumEntry>
    <EnumEntry Name="Mono16" NameSpace="Standard"><Value>0x01100007</Value></EnumEntry>
    <EnumEntry Name="BayerGR8" NameSpace="Standard"><Value>0x01080008</Value></EnumEntry>
    <EnumEntry Name="BayerRG8" NameSpace="Standard"><Value>0x01080009</Value></EnumEntry>
    <EnumEntry Name="BayerGB8" NameSpace="Standard"><Value>0x0108000A</Value></EnumEntry>
    <EnumEntry Name="BayerBG8" NameSpace="Standard"><Value>0x0108000B</Value></EnumEntry>
    <EnumEntry Name="BayerGR12" NameSpace="Standard"><Value>0x01100010</Value></EnumEntry>
    <EnumEntry Name="BayerRG12" NameSpace="Standard"><Value>0x01100011</Value></EnumEntry>
    <EnumEntry Name="BayerGB12" NameSpace="Standard"><Value>0x01100012</Value></EnumEntry>
    <EnumEntry Name="BayerBG12" NameSpace="Standard"><Value>0x01100013</Value></EnumEntry>
    <EnumEntry Name="BayerGR12p" NameSpace="Standard"><Value>0x010C0057</Value></EnumEntry>
    <EnumEntry Name="BayerRG12p" NameSpace="Standard"><Value>0x010C0059</Value></EnumEntry>
    <EnumEntry Name="BayerGB12p" NameSpace="Standard"><Value>0x010C0055</Value></EnumEntry>
    <EnumEntry Name="BayerBG12p" NameSpace="Standard"><Value>0x010C0053</Value></EnumEntry>
    <EnumEntry Name="RGB8" NameSpace="Standard"><Value>0x02180014</Value></EnumEntry>
    <EnumEntry Name="BGR8" NameSpace="Standard"><Value>0x02180015</Value></EnumEntry>
    <pValue>PixelFormatReg</pValue>
  </Enumeration>
  <IntReg Name="PixelFormatReg" NameSpace="Custom">
    <Address>0x128</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>

  <Category Name="AcquisitionControl" NameSpace="Standard">
    <pFeature>AcquisitionMode</pFeature>
    <pFeature>AcquisitionStart</pFeature>
    <pFeature>AcquisitionStop</pFeature>
    <pFeature>AcquisitionFrameRate</pFeature>
    <pFeature>ExposureTime</pFeature>
    <pFeature>TriggerSelector</pFeature>
    <pFeature>TriggerMode</pFeature>
    <pFeature>TriggerSource</pFeature>
    <pFeature>TriggerSoftware</pFeature>
    <pFeature>LinePulseRate</pFeature>
  </Category>
  <Enumeration Name="AcquisitionMode" NameSpace="Standard">
    <EnumEntry Name="Continuous" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <pValue>AcquisitionModeReg</pValue>
  </Enumeration>
  <IntReg Name="AcquisitionModeReg" NameSpace="Custom">
    <Address>0x12c</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Command Name="AcquisitionStart" NameSpace="Standard">
    <pValue>AcquisitionReg</pValue><CommandValue>1</CommandValue>
  </Command>
  <Command Name="AcquisitionStop" NameSpace="Standard">
    <pValue>AcquisitionReg</pValue><CommandValue>0</CommandValue>
  </Command>
  <IntReg Name="AcquisitionReg" NameSpace="Custom">
    <Address>0x124</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Float Name="AcquisitionFrameRate" NameSpace="Standard">
    <Description>Frames per second of the free-running camera.</Description>
    <pValue>FrameRateFromPeriod</pValue><Min>0.1</Min><Max>1000.0</Max><Unit>Hz</Unit>
  </Float>
  <Converter Name="FrameRateFromPeriod" NameSpace="Custom">
    <FormulaTo>1000000.0 / FROM</FormulaTo><FormulaFrom>1000000.0 / TO</FormulaFrom>
    <pValue>FramePeriodReg</pValue><Slope>Decreasing</Slope>
  </Converter>
  <IntReg Name="FramePeriodReg" NameSpace="Custom">
    <Address>0x138</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Float Name="ExposureTime" NameSpace="Standard">
    <Description>How long the shutter is open, in microseconds: more light, and more motion blur.</Description>
    <pValue>ExposureFromReg</pValue><Min>10.0</Min><Max>1000000.0</Max><Unit>us</Unit>
  </Float>
  <Converter Name="ExposureFromReg" NameSpace="Custom">
    <FormulaTo>FROM</FormulaTo><FormulaFrom>TO</FormulaFrom><pValue>ExposureReg</pValue><Slope>Increasing</Slope>
  </Converter>
  <IntReg Name="ExposureReg" NameSpace="Custom">
    <Address>0x120</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Enumeration Name="TriggerSelector" NameSpace="Standard">
    <EnumEntry Name="FrameStart" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <pValue>TriggerSelectorValue</pValue>
  </Enumeration>
  <Integer Name="TriggerSelectorValue" NameSpace="Custom"><Value>0</Value></Integer>
  <Enumeration Name="TriggerMode" NameSpace="Standard">
    <EnumEntry Name="Off" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <EnumEntry Name="On" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <pValue>TriggerModeReg</pValue>
  </Enumeration>
  <IntReg Name="TriggerModeReg" NameSpace="Custom">
    <Address>0x300</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Enumeration Name="TriggerSource" NameSpace="Standard">
    <EnumEntry Name="Line0" NameSpace="Standard"><Value>0</Value></EnumEntry>
    <EnumEntry Name="Software" NameSpace="Standard"><Value>1</Value></EnumEntry>
    <pValue>TriggerSourceReg</pValue>
  </Enumeration>
  <IntReg Name="TriggerSourceReg" NameSpace="Custom">
    <Address>0x1020</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Float Name="LinePulseRate" NameSpace="Custom">
    <Description>Pulses a second on the simulated input Line0.</Description>
    <pValue>LineRateFromPeriod</pValue><Min>0.1</Min><Max>200.0</Max><Unit>Hz</Unit>
  </Float>
  <Converter Name="LineRateFromPeriod" NameSpace="Custom">
    <FormulaTo>1000000.0 / FROM</FormulaTo><FormulaFrom>1000000.0 / TO</FormulaFrom>
    <pValue>LinePeriodReg</pValue><Slope>Decreasing</Slope>
  </Converter>
  <IntReg Name="LinePeriodReg" NameSpace="Custom">
    <Address>0x1024</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <Command Name="TriggerSoftware" NameSpace="Standard">
    <pValue>TriggerSoftwareReg</pValue><CommandValue>1</CommandValue>
  </Command>
  <IntReg Name="TriggerSoftwareReg" NameSpace="Custom">
    <Address>0x30c</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>

  <Category Name="AnalogControl" NameSpace="Standard">
    <pFeature>Gain</pFeature>
  </Category>
  <Float Name="Gain" NameSpace="Standard">
    <Description>Amplification before the converter, in decibels (20 dB: ten times the number).</Description>
    <pValue>GainFromReg</pValue><Min>0.0</Min><Max>36.0</Max><Unit>dB</Unit>
  </Float>
  <Converter Name="GainFromReg" NameSpace="Custom">
    <FormulaTo>FROM * 10.0</FormulaTo><FormulaFrom>TO / 10.0</FormulaFrom><pValue>GainReg</pValue>
    <Slope>Increasing</Slope>
  </Converter>
  <IntReg Name="GainReg" NameSpace="Custom">
    <Address>0x110</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>

  <Category Name="LastFrame" NameSpace="Custom">
    <pFeature>LastFrameId</pFeature>
    <pFeature>LastFrameNumber</pFeature>
    <pFeature>LastExposureTime</pFeature>
    <pFeature>LastGain</pFeature>
    <pFeature>LastHandTime</pFeature>
  </Category>
  <IntReg Name="LastFrameId" NameSpace="Custom">
    <Description>Number that the last frame was sent with: 16 bits.</Description>
    <Address>0x1000</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Cachable>NoCache</Cachable>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <IntReg Name="LastFrameNumber" NameSpace="Custom">
    <Description>Frames taken, counted from 1.</Description>
    <Address>0x1004</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Cachable>NoCache</Cachable>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <IntReg Name="LastExposureTime" NameSpace="Custom">
    <Description>Exposure of the last frame, in microseconds.</Description>
    <Address>0x1008</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Cachable>NoCache</Cachable>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <IntReg Name="LastGain" NameSpace="Custom">
    <Description>Gain of the last frame, in tenths of a decibel.</Description>
    <Address>0x100c</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Cachable>NoCache</Cachable>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>
  <IntReg Name="LastHandTime" NameSpace="Custom">
    <Description>How far the simulated hand had come at the last frame, in milliseconds.</Description>
    <Address>0x1010</Address><Length>4</Length><AccessMode>RO</AccessMode><pPort>Device</pPort>
    <Cachable>NoCache</Cachable>
    <Sign>Unsigned</Sign><Endianess>BigEndian</Endianess>
  </IntReg>

  <Category Name="TransportLayerControl" NameSpace="Standard">
    <pFeature>PayloadSize</pFeature>
  </Category>
  <IntSwissKnife Name="PayloadSize" NameSpace="Standard">
    <pVariable Name="W">Width</pVariable><pVariable Name="H">Height</pVariable>
    <pVariable Name="CODE">PixelFormatReg</pVariable>
    <Formula>W * H * ((CODE >> 16) &amp; 0xFF) / 8</Formula>
  </IntSwissKnife>
  <Integer Name="TLParamsLocked" NameSpace="Standard">
    <Visibility>Invisible</Visibility><Value>0</Value><Min>0</Min><Max>1</Max>
  </Integer>

  <Port Name="Device" NameSpace="Standard"/>
</RegisterDescription>
)xml";

}  // namespace ulf::acquisition
